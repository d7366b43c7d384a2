"""How long do an exported model's prediction and compensation take, against kinematics by CasADi
and kinematics with gravity torques by Pinocchio?

python benchmarks/controller.py [--compiler gcc]      (each is compared where it is installed: pip
                                                      install 'lostmotion[benchmark-controller]')
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import lostmotion

EXAMPLES = Path(__file__).parents[1] / "examples"
FLAGS = ["-O2", "-std=gnu99", "-w"]


def kinematics(model: Any, folder: Path) -> list[str]:
    """Write pose and Jacobian of the tool as CasADi's C source and return the flags that compile it
    in; none without CasADi.
    """
    if importlib.util.find_spec("casadi") is None:
        return []
    import casadi

    q = casadi.SX.sym("q", len(model.tables.joints))
    turn, point, axes = casadi.SX.eye(3), casadi.SX.zeros(3), []
    for record in model.tables.records[1:]:
        if not record.carries_tool:
            continue
        exact = np.where(
            np.abs(record.pose - np.round(record.pose)) < 1e-15, np.round(record.pose), record.pose
        )
        point = point + turn @ casadi.SX(casadi.sparsify(casadi.DM(exact[:3, 3])))
        turn = turn @ casadi.SX(casadi.sparsify(casadi.DM(exact[:3, :3])))
        if record.joint >= 0 and not record.slides:
            cosine, sine, spin = (
                casadi.cos(q[record.joint]),
                casadi.sin(q[record.joint]),
                casadi.SX(3, 3),
            )
            spin[0, 0], spin[0, 1], spin[1, 0], spin[1, 1], spin[2, 2] = (
                cosine,
                -sine,
                sine,
                cosine,
                1,
            )
            turn = turn @ spin
            axes.append((turn[:, 2], point))
    jacobian = casadi.horzcat(
        *[casadi.vertcat(axis, casadi.cross(axis, point - origin)) for axis, origin in axes]
    )
    found = casadi.Function(
        "kinematics",
        [q],
        [casadi.vertcat(casadi.vec(turn), point), casadi.densify(jacobian)],
        {"cse": True},
    )
    here = Path.cwd()
    os.chdir(folder)  # CasADi writes into the working folder alone
    found.generate("kinematics.c")
    os.chdir(here)
    return ["-DWITH_CASADI", str(folder / "kinematics.c")]


def pinocchio_lines(folder: Path) -> list[str]:
    """Return the lines to print on Pinocchio in C++: the UR5e's frame Jacobian, and that with
    gravity torques; why not, where it cannot be built.
    """
    prefixes = [Path(each) / "cmeel.prefix" for each in sys.path]
    headers = [
        prefix / "include" / name
        for name in (".", "eigen3")
        for prefix in prefixes
        if (prefix / "include" / name).is_dir()
    ]
    libraries = [
        prefix / "lib" for prefix in prefixes if list(prefix.glob("lib/libpinocchio_default.*"))
    ]
    if (
        importlib.util.find_spec("pinocchio") is None
        or not libraries
        or not any(each.name == "eigen3" for each in headers)
    ):
        return [
            (
                "Pinocchio in C++: not compared, its wheel (pin) or Eigen's (cmeel-eigen) is not "
                "installed"
            )
        ]
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(EXAMPLES / "ur5e.urdf"))
    rows = [[model.njoints - 1]]
    for number in range(1, model.njoints):
        placed, body = model.jointPlacements[number], model.inertias[number]
        axis = "XYZ".index(model.joints[number].shortname()[-1])
        rows.append(
            [
                axis,
                *np.column_stack([placed.rotation, placed.translation]).ravel(),
                body.mass,
                *body.lever,
            ]
        )
    tool = model.frames[model.getFrameId("tool0")].placement
    rows.append([*np.column_stack([tool.rotation, tool.translation]).ravel()])
    given = "\n".join(" ".join(f"{each:.17g}" for each in row) for row in rows)
    # Pinocchio's own build sets the two macros.
    flags = [
        "-O2",
        "-std=c++17",
        "-w",
        "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
        "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    ]
    flags += [f"-I{each}" for each in headers] + [
        each for library in libraries for each in (f"-L{library}", f"-Wl,-rpath,{library}")
    ]
    program, main_file = folder / "pinocchio", Path(__file__).with_name("pinocchio.cpp")
    done = subprocess.run(
        ["g++", main_file, *flags, "-lpinocchio_default", "-o", program],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return [f"Pinocchio in C++: not compared, it does not compile here: {done.stderr[:300]}"]
    runs = [
        subprocess.run(
            [program], input=given, capture_output=True, text=True, check=True
        ).stdout.split()
        for _ in range(3)
    ]
    jacobian, gravity = (1e6 * float(np.median([float(run[k]) for run in runs])) for k in range(2))
    return [
        (
            f"Pinocchio in C++, UR5e, double: forward kinematics and frame Jacobian {jacobian:.2f} "
            f"us, with gravity torques {gravity:.2f} us"
        )
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--compiler", default="gcc")
    compiler = parser.parse_args().compiler
    with tempfile.TemporaryDirectory() as made:
        print(*pinocchio_lines(Path(made)), sep="\n")
    print(
        "arm, precision, form: predict us, compensate position us, pose us | over predict | "
        "CasADi us, predict over it | slowest over fastest pose | bytes"
    )
    for name in ("ur5e.urdf", "z-arm.toml"):
        model = lostmotion.controller(EXAMPLES / name)
        for precision, unroll in (
            ("double", False),
            ("double", True),
            ("float", False),
            ("float", True),
        ):
            with tempfile.TemporaryDirectory() as made:
                folder = Path(made)
                lostmotion.export_c(
                    EXAMPLES / name, out=folder / "model", precision=precision, unroll=unroll
                )
                source = folder / "model" / "src"
                core, tables = folder / "core.o", folder / "tables.o"
                for file, target in (("lm_core.c", core), ("lm_model.c", tables)):
                    subprocess.run(
                        [compiler, *FLAGS, "-c", source / file, "-o", target], check=True
                    )
                with_casadi = kinematics(model, folder)
                program, main_file = folder / "program", Path(__file__).with_name("controller.c")
                subprocess.run(
                    [
                        compiler,
                        *FLAGS,
                        "-I",
                        source,
                        *with_casadi,
                        main_file,
                        core,
                        tables,
                        "-o",
                        program,
                        "-lm",
                    ],
                    check=True,
                )
                runs = [
                    list(
                        map(
                            float,
                            subprocess.run(
                                [program], capture_output=True, text=True, check=True
                            ).stdout.split(),
                        )
                    )
                    for _ in range(3)
                ]
                sizes = subprocess.run(
                    ["size", core, tables], capture_output=True, text=True, check=True
                ).stdout.split("\n")[1:3]
            predict, position, pose, casadi, spread, _ = np.median(runs, axis=0)
            compared = (
                f"{casadi * 1e6:.3f}, {predict / casadi:.1f}" if with_casadi else "not installed"
            )
            code, data = (sum(map(int, line.split()[:2])) for line in sizes)
            times = ", ".join(f"{each * 1e6:.2f}" for each in (predict, position, pose))
            form = "unrolled" if unroll else "looped"
            ratios = f"{position / predict:.2f}, {pose / predict:.2f}"
            print(
                f"{name}, {precision}, {form}: {times} | {ratios} | {compared} | {spread:.2f} "
                f"| {code} + {data}"
            )


if __name__ == "__main__":
    main()
