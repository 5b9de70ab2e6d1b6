"""From measured values to unknown numbers: least squares, the noise, intervals, what the data cannot tell.

Nothing here knows a rod: what is fitted are `Predictions`, values that depend on unknowns.
"""
