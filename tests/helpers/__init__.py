"""What several test modules share: models, files, results in closed form, and tools to look at them."""
