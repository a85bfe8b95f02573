"""Processes that compute as other types of CPU do, and how far their tables differ.

NumPy, OpenBLAS, Arrow and the C library choose their kernels by what the CPU can do. Told that it
can do less, they choose those of another CPU, as far as they have a switch.
"""

import json
import platform
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy._core._multiarray_umath import __cpu_features__ as features
from pandas.api.types import is_object_dtype

from oilfilm.releases.code_tree import blas_libraries
from oilfilm.releases.compare import KERNEL_CHANGE
from oilfilm.releases.manifest import Environment

_SIMD = np.show_config(mode="dicts")["SIMD Extensions"]
# Instructions that this NumPy has kernels for, beyond those that it always uses.
_DISPATCHED = [*_SIMD.get("found", []), *_SIMD.get("not found", [])]
_AVX512 = [name for name in _DISPATCHED if "512" in name or name == "X86_V4"]
_NO_AVX512 = {
    "NPY_DISABLE_CPU_FEATURES": " ".join(_AVX512),
    "ARROW_USER_SIMD_LEVEL": "AVX2",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512DQ,-AVX512BW",
}
_NO_AVX = {
    "NPY_DISABLE_CPU_FEATURES": " ".join(_DISPATCHED),
    "ARROW_USER_SIMD_LEVEL": "NONE",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F",
}


@dataclass(frozen=True)
class Cpu:
    """A type of CPU.

    Attributes:
        coretype: Its name for OpenBLAS.
        core: The name of its kernel as OpenBLAS reports it: several CPUs share a kernel, which has
            the name of the first of them in OpenBLAS's list.
        needs: What this machine must be able to do. OpenBLAS does not check it: a program would
            end with an illegal instruction.
        switches: Variables of the environment that tell other libraries the same.
    """

    coretype: str
    core: str
    needs: str
    switches: Mapping[str, str]

    @property
    def environment(self) -> dict[str, str]:
        """Variables of the environment of a process that computes as this CPU does."""
        # threads would only slow down: they change no byte (`make bench NAME=cpu_types`)
        return {"OPENBLAS_CORETYPE": self.coretype, "OPENBLAS_NUM_THREADS": "1", **self.switches}

    def lacking(self) -> str:
        """Why this machine cannot compute as this CPU does; empty where it can."""
        if platform.machine() not in {"x86_64", "AMD64"}:
            return f"{self.coretype} is a CPU of x86-64, this one is {platform.machine()}"
        if not all("openblas" in library for library in blas_libraries() or ["unknown"]):
            return "NumPy or SciPy has another BLAS than OpenBLAS"
        return "" if features[self.needs] else f"this CPU lacks {self.needs}"

    def refuse_other(self, made_by: Environment) -> None:
        """Fail where a process has not computed as this CPU does."""
        taken = {library.split()[-1] for library in made_by.blas or []}
        assert taken == {self.core}, f"OpenBLAS took {taken} for {self.coretype}"
        disabled = set(self.switches.get("NPY_DISABLE_CPU_FEATURES", "").split())
        assert not disabled & set(made_by.cpu.split()), f"NumPy uses {made_by.cpu}"


# Zen and its successors without AVX-512 have Haswell's kernel, those with it Skylake's.
CPUS = {
    cpu.coretype: cpu
    for cpu in (
        Cpu("Prescott", "Katmai", "SSE3", _NO_AVX),
        Cpu("Sandybridge", "Sandybridge", "AVX", _NO_AVX),
        Cpu("Haswell", "Haswell", "AVX2", _NO_AVX512),
        Cpu("SkylakeX", "SkylakeX", "AVX512_SKX", {}),
    )
}
# Prints the environment that a manifest would name.
ENVIRONMENT = (
    "from oilfilm.base.home import HOME; from oilfilm.releases.code_tree import environment\n"
    "print(environment(HOME).model_dump_json())"
)


def environment_of(output: str) -> Environment:
    """The environment that a program has printed in its last line."""
    return Environment(**json.loads(output.splitlines()[-1]))


# ---------------------------------------------------------------- differences

# A number without an error of its own, relative: a hundred thousand times what rounding did to any.
_RELATIVE = 1e-9
# Traction near zero is a difference of terms of the size of the largest traction: rounding counts
# beside this share of it.
_CANCELLATION = 1e-3
# Quantities of a bearing's contacts that are a speed over the entrainment speed, or follow from it.
_OVER_ENTRAINMENT = {
    *("largest_slide_roll_ratio", "inner_mean_slide_roll_ratio", "outer_mean_slide_roll_ratio"),
    *("inner_slide_roll_ratio", "lambda_ratio"),
}
# Rounding counts beside this size where a quantity is smaller. A slip near rolling is the small
# rest of two speeds. A film of a contact that hardly entrains oil follows from such a rest.
_SMALLEST_SIZES = {"inner_slide_roll_ratio": 1e-3, "lambda_ratio": 0.1, "heated_lambda_ratio": 0.1}
# The numbers of this claim are standard errors of constants.
_CLAIM_ON_ERRORS = "uniquely-determined"
# What would be zero without rounding, beside 1. The verdict beside it is compared exactly.
_RESIDUES = {
    *("sse_spread", "gradient_cosine", "relative_error"),
    *("residual", "energy_error", "quadrature_error"),
}
# Numbers that are in standard errors, or beside 1.
_IN_STANDARD_ERRORS = {
    *("signed_root", "correlation", "constant_spread", "logarithm"),
    *("torque_share", "slip_share"),
}
# Errors, and numbers that are in errors: by bootstrap and draws their own error is a tenth of them.
_ERROR = re.compile(
    r"(_se|_uncertainty|_systematic|standard_error|_sd|_sd_k|run_scatter|misfit)$"
    # changes of a rig that would be seen, and what the next run scatters more than expected
    r"|^uncertainty_|^compatibility$|^seen_|^(point|curve)_factor$"
)


def table_changes(before: Path, after: Path) -> Iterator[str]:
    """Sentences on all that differs between the tables of two folders by more than a kernel may.

    Texts, flags, counts, rows and what is null must be equal. A number may differ by
    `KERNEL_CHANGE` of its standard error.
    """
    names = [{path.relative_to(top) for path in top.rglob("*.parquet")} for top in (before, after)]
    for name in names[0] ^ names[1]:
        yield f"{name}: is in one of the folders only"
    for name in sorted(names[0] & names[1]):
        old, new = (_with_errors(top / name) for top in (before, after))
        if len(old) != len(new) or list(old) != list(new):
            yield f"{name}: {len(old)} and {len(new)} rows, or other columns"
            continue
        for column in old:
            unlike = _unlike(old, new, column)
            if unlike.any():
                row = int(unlike.argmax())
                values = " and ".join(repr(frame[column].iloc[row]) for frame in (old, new))
                yield f"{name}: {column}: {unlike.sum()} of {len(old)} rows, first {values}"


def _with_errors(path: Path) -> pd.DataFrame:
    """A table; refits with the standard errors of their constants."""
    frame = pd.read_parquet(path)
    for name in frame.columns[[is_object_dtype(kind) for kind in frame.dtypes]]:
        # lists come as arrays, which cannot be compared
        frame[name] = frame[name].map(lambda value: tuple(value) if np.ndim(value) else value)
    if path.stem != "refits":
        return frame
    key = ["oil", "law", "constant"]
    errors = pd.read_parquet(path.with_stem("coefficients"), columns=[*key, "standard_error"])
    return frame.merge(errors, on=key, how="left")


def _unlike(old: pd.DataFrame, new: pd.DataFrame, column: str) -> np.ndarray:
    """Rows in which a column differs by more than a kernel may make it differ."""
    one, two = old[column], new[column]
    if one.dtype.kind != "f":
        return ~((one == two) | (one.isna() & two.isna())).to_numpy(bool)
    change = (one - two).abs()
    return ((one.isna() != two.isna()) | (change > _tolerance(old, column))).to_numpy(bool)


def _size(frame: pd.DataFrame, column: str) -> pd.Series:
    """Size of each number of a column, of which rounding is a share."""
    size = frame[column].abs().clip(lower=_SMALLEST_SIZES.get(column, 0.0))
    if column == "traction_coefficient":
        return size.clip(lower=_CANCELLATION * size.max())
    # Film and slip follow from the entrainment speed. Where that is the small rest of two large
    # speeds, its cancellation is as large as the slip.
    if column in _OVER_ENTRAINMENT and "largest_slide_roll_ratio" in frame:
        return size * frame["largest_slide_roll_ratio"].clip(lower=1.0)
    # a part of the torque may be the small rest of two large ones
    if column.endswith("_torque_n_m") and "torque_n_m" in frame:
        return frame["torque_n_m"].abs()
    return size


def _tolerance(frame: pd.DataFrame, column: str) -> pd.Series:
    """Largest change of each number of a column that another kernel may make."""
    size = _size(frame, column)
    if column in _RESIDUES:
        return pd.Series(_RELATIVE, frame.index)
    if column in _IN_STANDARD_ERRORS:
        return pd.Series(KERNEL_CHANGE, frame.index)
    if "claim" in frame and column in ("value", "worst_value"):
        is_error = frame["claim"] == _CLAIM_ON_ERRORS
        return size * np.where(is_error, KERNEL_CHANGE, _RELATIVE)
    errors = [f"{re.sub('_(lower|upper)$', '', column)}{end}" for end in ("_se", "_uncertainty")]
    if "constant" in frame:
        errors.append("standard_error")
    # what a figure draws has lost its error; no picture shows so many digits
    drawn = "series" in frame
    allowed = (KERNEL_CHANGE if drawn or _ERROR.search(column) else _RELATIVE) * size
    for error in set(errors) & set(frame.columns):
        of_error = KERNEL_CHANGE * frame[error]
        allowed = of_error.where(of_error > 0, allowed)
    return allowed
