"""What the user says: materials, sections, rods, supports and loads, frozen and validated, in SI units."""
