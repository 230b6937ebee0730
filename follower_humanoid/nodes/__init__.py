"""One thin file per executable."""

import os

# Small matrices, several processes, few cores: more threads only wait for one another. Said before the
# libraries are loaded, which read it once.
for _library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")
