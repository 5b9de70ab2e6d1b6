"""The description of a whole model, its methods, and checks that its parts fit together."""
