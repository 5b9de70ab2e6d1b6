"""Pictures of models before they are solved."""
