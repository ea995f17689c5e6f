"""Error of a run: its parts, their sum, and the remedy for the largest part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any

from supple.summary import Summarized, Summary

__all__ = ["PARTS", "ErrorPart", "ErrorStatement"]

PARTS = ("basis", "step", "newton", "model")
"""Parts of the error of a run, in the order of tables."""

LARGE_MODEL = 0.05
"""Ratio of the model part to the size of the quantity, above which the statement warns."""
SMALL = 0.1
"""Ratio of the sum to the allowed error, below which no part needs a remedy."""


@dataclass(frozen=True)
class ErrorPart:
    """One part of the error of a run.

    value : float   in the unit of the quantity; infinite where it is unknown
    how : str       method of the estimate
    remedy : str    change of the model or the run that reduces this part
    """

    value: float
    how: str
    remedy: str = ""


@dataclass(frozen=True, repr=False)
class ErrorStatement(Summarized):
    """The error of a run in one quantity, with its parts.

    of : str            name of the quantity and of its norm
    size : float        largest value of the quantity, in its unit; relative errors are relative to it
    basis : ErrorPart   due to motion outside the bases of reduced bodies
    step : ErrorPart    due to the size of the time steps
    newton : ErrorPart  due to the Newton tolerance; at least ten times this tolerance times `size`
    model : ErrorPart   due to the kinematics: spurious strains of elements and ties that rotate in the frame
    allowed : float     largest allowed sum of the parts; None if there is no limit
    quantity : str      kind of the quantity, which determines its unit: "length", "force", ...

    A part that was not estimated is None; the error is then at least the sum of the other parts.
    """

    of: str
    size: float
    basis: ErrorPart | None = None
    step: ErrorPart | None = None
    newton: ErrorPart | None = None
    model: ErrorPart | None = None
    allowed: float | None = None
    quantity: str = ""

    def summary(self) -> Summary:
        """Sum of the parts, allowed error, parts and remedy."""
        bound = "at least " if self.missing else ""
        rows = [("size of the quantity", f"{self.size:.3g}")]
        rows += [] if self.allowed is None else [("allowed", f"{self.allowed:.2g}")]
        rows += [(name, f"{part.value:.2g}  {part.how}") for name, part in self.parts.items()]
        rows += [("not estimated", ", ".join(self.missing))] if self.missing else []
        rows += [("remedy", self.advice)] if self.advice else []
        return Summary(f"Error of {self.of}: {bound}{self.at_least:.2g}", rows)

    @property
    def parts(self) -> dict[str, ErrorPart]:
        """The parts that were estimated, by name, in the order of `PARTS`."""
        every = {name: getattr(self, name) for name in PARTS}
        return {name: part for name, part in every.items() if part is not None}

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the parts that were not estimated."""
        return tuple(name for name in PARTS if name not in self.parts)

    @property
    def at_least(self) -> float:
        """Sum of the estimated parts, each taken as positive."""
        return sum((part.value for part in self.parts.values()), 0.0)

    @property
    def total(self) -> float | None:
        """Sum of all four parts; None if a part was not estimated."""
        return None if self.missing else self.at_least

    @property
    def largest(self) -> str | None:
        """Name of the largest part; None if no part is estimated or all parts are zero."""
        known = {name: part.value for name, part in self.parts.items()}
        if not any(known.values()):
            return None
        return max(known, key=lambda name: known[name])

    @property
    def model_warning(self) -> str:
        """Text with the model part and its remedies, if this part exceeds 5 % of `size`; otherwise empty."""
        if self.model is None or not self.model.value > LARGE_MODEL * self.size:
            return ""
        share = f" ({self.model.value / self.size:.0%} of the quantity)" if self.size else ""
        remedies = "use an intrinsic body if it is slender, or explicit elements"
        return (
            f"the kinematics of the model cause an error of about {self.model.value:.2g}{share}. No basis "
            "and no step reduces this error, and its estimate holds for small errors only: "
            + (f"{self.model.remedy}, or {remedies}" if self.model.remedy else remedies)
        )

    @property
    def advice(self) -> str:
        """Text with the largest part, its ratio to the second largest part, and its remedy.

        If the model part exceeds 5 % of `size`, the text begins with `model_warning`. If the sum of all parts
        is less than a tenth of the allowed error, the text is only the ratio of both. If no part is
        estimated, or all are zero, the text is empty.
        """
        name = self.largest
        if name is None:
            return ""
        if self.total is not None and self.allowed is not None and self.total < SMALL * self.allowed:
            return f"the sum is {self.total / self.allowed:.2g} of the allowed error"
        if self.model_warning:
            return self.model_warning if name == "model" else f"{self.model_warning}; {self._of(name)}"
        return self._of(name)

    def _of(self, name: str) -> str:
        values = {key: part.value for key, part in self.parts.items()}
        remedy = self.parts[name].remedy
        second = max((key for key in values if key != name), key=lambda key: values[key], default=None)
        if not isfinite(values[name]):
            said = f"the error of the {_WORD[name]} is unknown"
        elif second is None or values[second] <= 0:
            said = f"the {_WORD[name]} causes all of the error"
        else:
            ratio = f"{values[name] / values[second]:.2g}"
            said = f"the error of the {_WORD[name]} is {ratio} times that of the {_WORD[second]}"
        return f"{said}: {remedy}" if remedy else said

    @property
    def is_met(self) -> bool:
        """Whether the sum of the estimated parts is at most `allowed`; True if `allowed` is None."""
        return self.allowed is None or self.at_least <= self.allowed

    def plain(self) -> dict[str, Any]:
        """Numbers and texts for JSON; None for a number that is not finite."""
        return {
            "of": self.of,
            "quantity": self.quantity,
            "size": self.size,
            "parts": {
                name: {"value": _finite(part.value), "how": part.how, "remedy": part.remedy}
                for name, part in self.parts.items()
            },
            "total": None if self.total is None else _finite(self.total),
            "at_least": _finite(self.at_least),
            "allowed": self.allowed,
            "largest": self.largest,
            "advice": self.advice,
        }

    @classmethod
    def from_plain(cls, numbers: Mapping[str, Any]) -> ErrorStatement:
        """The statement from the mapping that `plain` returns."""
        parts = {
            name: ErrorPart(
                float("inf") if part["value"] is None else part["value"], part["how"], part["remedy"]
            )
            for name, part in numbers["parts"].items()
        }
        known = {item.name for item in fields(cls)}
        return cls(
            numbers["of"],
            numbers["size"],
            allowed=numbers["allowed"],
            quantity=numbers.get("quantity", ""),  # absent in files of earlier versions
            **{name: part for name, part in parts.items() if name in known},
        )


_WORD = {"basis": "basis", "step": "step", "newton": "Newton tolerance", "model": "kinematics of the model"}
"""Names of the parts of the error in sentences."""


def _finite(value: float) -> float | None:
    return float(value) if isfinite(value) else None
