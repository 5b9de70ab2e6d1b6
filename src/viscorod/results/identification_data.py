"""What the data set of an identification has: names, dimensions, units and what they mean."""

from __future__ import annotations

from viscorod.results.stateless_result import Variables

__all__ = ["VARIABLES"]

HALF = "half of the 95 % interval"
VARIABLES: Variables = {
    "unknown": (("unknown",), "", "key of a number of the case, or name of a number of the measurement"),
    "unknown_unit": (
        ("unknown",),
        "",
        "SI unit of the number, 1 of a plain one; empty where it is not known",
    ),
    "nuisance": (("unknown",), "", "1 where it belongs to the measurement and not to the model"),
    "start": (("unknown",), "", "where the search began"),
    "estimate": (("unknown",), "", "at the least sum of squares, SI"),
    "relative": (("unknown",), "", "1 where the standard error is in parts of the estimate"),
    "standard_error": (("unknown",), "", "of the estimate, SI or in parts of it"),
    "low": (("unknown",), "", "lower end of the interval, SI; 0 where it is open"),
    "high": (("unknown",), "", "upper end of the interval, SI; 0 where it is open"),
    "low_open": (("unknown",), "", "1 where nothing limits it from below"),
    "high_open": (("unknown",), "", "1 where nothing limits it from above"),
    "interval_by": (("unknown",), "", "how the interval was found"),
    "covariance": (
        ("unknown", "other_unknown"),
        "",
        "of the unknowns along what the data see, as standard errors",
    ),
    "unseen": (
        ("direction", "unknown"),
        "",
        "directions that the data do not see, as powers of the unknowns",
    ),
    "draw": (("chain", "step", "unknown"), "", "draws of the posterior, SI; none unless they were asked for"),
    "draw_density": (("chain", "step"), "1", "logarithm of the density there, up to a constant"),
    "measured": (("value",), "", "what was measured, SI"),
    "predicted": (("value",), "", "what the fitted model says, SI"),
    "deviation": (("value",), "", "standard deviation of the noise of the value, SI"),
    "white": (("value",), "", "residual less what its own past tells of it, over its standard deviation"),
    "place": (("value",), "", "time [s], frequency [Hz], load or number of the value"),
    "series_of": (("value",), "", "number of the series, from 0"),
    "series": (("series",), "", "what one channel of one record gave"),
    "quantity": (("series",), "", "what was measured, in words; names of several that follow each other"),
    "quantity_unit": (("series",), "", "SI unit of it; empty where it is not known"),
    "place_unit": (("series",), "", "unit of the place of its values"),
    "noise": (("series",), "", "standard deviation of the residuals, typical, SI"),
    "noise_told": (("series",), "", "what was told of it, SI; 0 where nothing was"),
    "noise_order": (("series",), "1", "terms of the autoregression of the residuals"),
    "effective_count": (("series",), "1", "values that would tell as much if they were independent"),
    "whiteness": (
        ("series",),
        "1",
        "probability of such an autocorrelation of white residuals (Ljung and Box)",
    ),
    "at_signal": (("series",), "1", "part of the power of the residuals at the frequency of the record"),
    "combination_value": (
        ("combination",),
        "",
        "value of what the data tell of several unknowns together, SI",
    ),
    "combination_low": (("combination",), "", "lower end of its interval"),
    "combination_high": (("combination",), "", "upper end of its interval"),
    "law_unknowns": (("law",), "1", "numbers that were fitted in a law compared on the same data"),
    "law_square": (("law",), "1", "sum of squares in units of the noise of the best"),
    "law_aicc": (("law",), "1", "Akaike's corrected criterion, less the least"),
    "law_bic": (("law",), "1", "Bayesian criterion, less the least"),
    "law_prediction": (
        ("law",),
        "1",
        "error of records left out, over the noise that was told of them or else their spread; 0 where none was",
    ),
    "foretold_frequency": (
        ("foretold",),
        "Hz",
        "natural frequency that a law foretells of a record left out",
    ),
    "foretold_frequency_width": (("foretold",), "Hz", HALF),
    "foretold_ratio": (("foretold",), "1", "damping ratio that it foretells"),
    "foretold_ratio_width": (("foretold",), "1", HALF),
    "left_out_frequency": (("foretold",), "Hz", "natural frequency that the record shows"),
    "left_out_frequency_width": (("foretold",), "Hz", HALF),
    "left_out_ratio": (("foretold",), "1", "damping ratio that it shows"),
    "left_out_ratio_width": (("foretold",), "1", HALF),
    "program_value": (("program_number",), "", "value of a damping input of another program"),
    "program_low": (("program_number",), "", "lower end of its interval"),
    "program_high": (("program_number",), "", "upper end of its interval"),
}
