"""How it is computed: discretisation, linear algebra, statics, transients, modes."""
