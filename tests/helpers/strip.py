"""A small clamped strip as the content of a case file."""


def content(analysis, **settings):
    """A rod of a tenth of a metre, clamped and pulled."""
    return {
        "title": "Strip",
        "materials": {
            "rubber": {
                "youngs_modulus": 1e6,
                "poissons_ratio": 0.3,
                "density": 1000.0,
                "damping": {"shear_time": 0.02, "bulk_time": 0.02},
            }
        },
        "sections": {"thin": {"shape": "rectangle", "width": 0.01, "height": 0.01}},
        "rods": {
            "beam": {
                "shape": "straight",
                "start": [0.0, 0.0, 0.0],
                "end": [0.3, 0.0, 0.0],
                "section": "thin",
                "material": "rubber",
                "elements": 1,
                "order": 3,
            }
        },
        "supports": [{"kind": "clamp", "at": "beam.start"}],
        "loads": [{"kind": "force", "at": "beam.end", "value": [0.0, 1e-3, 0.0], "until": 0.0}],
        analysis: settings,
    }
