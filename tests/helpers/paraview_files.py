"""Files for ParaView, read back by its own reader."""

import h5py
import pytest


def states_of(path):
    """The times of a file, and a function from the number of a state to its blocks by name."""
    pyvista = pytest.importorskip("pyvista", reason="reading files for ParaView back needs pyvista")
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    with h5py.File(path) as file:
        times = file["VTKHDF/rods/Steps/Values"][()].tolist()
    assert reader.GetNumberOfSteps() == len(times)

    def state(number):
        reader.SetStep(number)
        reader.Update()
        found = pyvista.wrap(reader.GetOutputDataObject(0))
        return {name: found[name].copy() for name in list(found.keys())}

    return times, state
