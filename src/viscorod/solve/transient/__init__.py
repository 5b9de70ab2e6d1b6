"""Motion in time: the driver, step control, events, saved states, integrators."""
