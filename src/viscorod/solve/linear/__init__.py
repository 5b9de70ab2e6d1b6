"""Linear algebra of models: matrices of 6x6 blocks, and the direct solvers that factorise them."""
