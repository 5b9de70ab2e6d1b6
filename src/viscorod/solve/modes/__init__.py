"""Small vibrations about an equilibrium, with and without Maxwell branches."""
