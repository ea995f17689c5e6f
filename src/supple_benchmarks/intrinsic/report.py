"""The tables of the intrinsic benchmark."""

from __future__ import annotations

from supple_benchmarks.table import Report, Table, table_of

__all__ = ["tables"]


def tables(report: Report) -> list[Table]:
    """The tables of the complete report: single numbers in the first, then one table per study."""
    flying = report["u_beam"]
    numbers = {
        "Phi_1": report["orthonormality"]["phi1"],
        "Phi_2": report["orthonormality"]["phi2"],
        "energy drift": report["energy_drift"],
        "small vibration of the box, from linear": report["box_beam"]["small_from_linear"],
        "order, elastica": report["elastica_order"],
        "order, centre of mass": flying["order"],
    }
    return [
        table_of("Errors of orthonormality, energy and a small vibration; convergence orders", [numbers]),
        table_of("The elastica, P L^2 / E I = 10: error of the tip over the length", report["elastica"]),
        table_of("The bend of 45 degrees", [dict(zip("xyz", report["simo45"]["tip"], strict=True))]),
        table_of("The box beam's frequencies, rad/s", report["box_beam"]["frequencies"]),
        table_of("The box on stations compared with its shell model", report["box_beam"]["against_shells"]),
        table_of("The U's centre of mass, by stations", [flying["com_error"]]),
        table_of("Truncated and residual modes of the U", flying["residualised"]),
        table_of("A strip by four methods against the elastica; the blade", report["agreement"]),
        table_of("Microseconds per step", report["speed"]),
    ]
