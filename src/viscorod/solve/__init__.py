"""How it is computed: discretisation, linear algebra, statics, transients, modes. Nothing here knows a formulation's formulas."""
