"""A rod under loads that follow functions of time."""

import viscorod as vr

ROWS = [0.0, 0.1, 0.1, 0.25, 0.3], [0.0, 1.0, -0.7, 0.4, 0.2]


def loaded_rod(model, functions, **given):
    """A soft rod with a force at its end, and one with an arm, for every function of time."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model.add(
        "rod",
        vr.Rod.straight(
            (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material, elements=1, order=4
        ),
    )
    for function in functions:
        model.force("rod.end", (0, 0.02, 0.01), time=function, **given)
        model.force("rod.end", (0, 0.003, 0), following=True, time=function, **given)
        model.distributed_force("rod", (0, 0, 0.01), time=function, **given)
    return model
