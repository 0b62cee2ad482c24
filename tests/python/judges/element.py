"""The C FMU of cosim/tests/element, compiled and packed: y = k u + b t, x' = a x + u by Euler."""

import subprocess
import zipfile

from conftest import ROOT

SOURCE = ROOT / "cosim" / "tests" / "element"


def pack(folder):
    """Path of the FMU."""
    library, fmu = folder / "element.so", folder / "element.fmu"
    compiler = ["cc", "-O2", "-shared", "-fPIC", "-w", "-o", library, SOURCE / "element.c"]
    subprocess.run(compiler, check=True)
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.write(SOURCE / "element.xml", "modelDescription.xml")
        archive.write(library, "binaries/linux64/element.so")
    return fmu
