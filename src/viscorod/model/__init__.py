"""The user's description of a model: materials, sections, rods, supports and loads, frozen and validated, in SI."""
