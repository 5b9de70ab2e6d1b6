"""Other programs on the cases of the work-precision comparison; one thread for everyone.

`pip install viscorod[bench]` brings them. Each module has a function `run(case, elements, **settings)`, whose
docstring tells how the case is modelled there and what differs from viscorod's.
"""

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
