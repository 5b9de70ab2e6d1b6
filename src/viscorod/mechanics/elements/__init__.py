"""Elements of rods: strains, internal forces and their tangents, Maxwell branches, held strains."""
