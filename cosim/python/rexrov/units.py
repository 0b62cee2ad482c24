"""Units as exponents of SI's base units: `m/s2`, `N.m`, `kg.m2/s`, `deg`."""

from __future__ import annotations

import math
import re

_BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
#: Symbols that are not base units: their definition and factor.
_DERIVED: dict[str, tuple[dict[str, int], float]] = {
    "1": ({}, 1.0),
    "%": ({}, 0.01),
    "g": ({"kg": 1}, 1e-3),
    "mm": ({"m": 1}, 1e-3),
    "cm": ({"m": 1}, 1e-2),
    "km": ({"m": 1}, 1e3),
    "us": ({"s": 1}, 1e-6),
    "ms": ({"s": 1}, 1e-3),
    "min": ({"s": 1}, 60.0),
    "h": ({"s": 1}, 3600.0),
    "deg": ({"rad": 1}, math.pi / 180.0),
    "rev": ({"rad": 1}, math.tau),
    "Hz": ({"s": -1}, 1.0),
    "N": ({"kg": 1, "m": 1, "s": -2}, 1.0),
    "Pa": ({"kg": 1, "m": -1, "s": -2}, 1.0),
    "kPa": ({"kg": 1, "m": -1, "s": -2}, 1e3),
    "bar": ({"kg": 1, "m": -1, "s": -2}, 1e5),
    "J": ({"kg": 1, "m": 2, "s": -2}, 1.0),
    "W": ({"kg": 1, "m": 2, "s": -3}, 1.0),
    "V": ({"kg": 1, "m": 2, "s": -3, "A": -1}, 1.0),
    "T": ({"kg": 1, "s": -2, "A": -1}, 1.0),
}
_SYMBOL = re.compile(r"([A-Za-z%]+|1)(-?\d+)?")


def base(unit: str) -> dict[str, str]:
    """The attributes of FMI's BaseUnit. Raises ValueError if the text is not a unit; an empty text is not one."""
    exponents, factor = dict.fromkeys(_BASES, 0), 1.0
    for sign, part in _parts(unit) if unit else ():
        found = _SYMBOL.fullmatch(part)
        symbol, power = (found[1], sign * int(found[2] or 1)) if found else (part, 0)
        made, size = ({symbol: 1}, 1.0) if symbol in _BASES else _DERIVED.get(symbol, (None, 0.0))
        if made is None:
            raise ValueError(f"there is no unit '{unit}'; write N.m for newton metre, m/s2 for metre per second squared")
        factor *= size**power
        for name, exponent in made.items():
            exponents[name] += power * exponent
    attributes = {name: str(exponent) for name, exponent in exponents.items() if exponent}
    return attributes if factor == 1.0 else {**attributes, "factor": repr(factor)}


def _parts(unit: str) -> list[tuple[int, str]]:
    """Symbols with their exponents, and whether they multiply or divide."""
    pieces = re.split(r"([./])", unit)
    signs = [1, *(1 if operator == "." else -1 for operator in pieces[1::2])]
    return list(zip(signs, pieces[::2]))
