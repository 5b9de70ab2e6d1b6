"""Back to three dimensions: stress, strain and loss at the points of a section, from section forces and strains."""
