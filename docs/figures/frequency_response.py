"""Draw the pictures of docs/howto/frequency_response.md: a strip of aluminium on a shaker."""

from pathlib import Path

import viscorod as vr

IMAGES = Path(__file__).parents[1] / "images"

measured = vr.ComplexModuli(frequency=[1.0, 1000.0], storage=[70e9, 70e9], tan_delta=[0.01, 0.01])
aluminium = vr.Material(poissons_ratio=0.33, density=2700.0, damping=measured)
model = vr.Model()
section = vr.Rectangle(0.025, 0.003)
model.add("beam", vr.Rod.straight((0, 0, 0), (0.4, 0, 0), section=section, material=aluminium))
model.clamp("beam.start")
shaken = model.frequency_response(inputs="base uz", outputs="beam.end uz", band=(5.0, 400.0))
for kind in ("bode", "nyquist"):
    shaken.plot(IMAGES / f"frequency_response_{kind}.png", kind)
print(shaken.report())
