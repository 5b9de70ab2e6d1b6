"""What identification needs of cases: their numbers by key, their predictions, their laws."""
