"""Begin an arm file from a template, or a sidecar from a URDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

from lostmotion.analyses.arguments import path_of
from lostmotion.analyses.result import Result
from lostmotion.analyses.signature import Argument, question, read_arguments, results_folder
from lostmotion.errors import LostmotionError, OutputExistsError, refuse_argument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.sheet import Sheet

Template = Literal[
    "z-arm",
    "six-axis",
    "scara",
    "gantry",
    "hobby",
    "palletiser",
    "linkage-palletiser",
    "five-bar",
    "delta",
    "hexapod",
]


@dataclass(frozen=True, repr=False)
class New(Result):
    """A file to begin with: `text`, and `path`, which `report()` writes; None for the list of
    templates.
    """

    text: str
    path: Path | None
    templates: Sequence[str]
    urdf: Path | None = None
    force: bool = False

    @property
    def sheet(self) -> Sheet:
        """Return what was begun and the commands that follow, or the templates."""
        from lostmotion.reporting.sheet import Sheet, table

        if self.path is None:
            from lostmotion.io.arm_templates import template_summary

            rows = [(each, template_summary(each)) for each in self.templates]
            return Sheet(
                name="templates",
                subject="templates",
                verdict="lostmotion new my-arm --template scara",
                sections=(table("templates", "Templates", ("value",), rows),),
            )
        file = str(self.path if self.urdf is None else self.urdf)
        if self.urdf is not None and self.path != self.urdf.with_suffix(".toml"):
            file += f" --sidecar {self.path}"
        study = f"lostmotion study {file}"
        again = f"Later, `{study} --force` replaces the first result by that of the changed file."
        folder = results_folder(self.urdf or self.path, "accuracy")
        if Path(folder).exists():
            study, again = f"{study} --force", f"It replaces the result in {folder}."
        verdict = (
            f"Next: `lostmotion check {file}` shows what is assumed, `{study}` predicts the "
            f"accuracy. {again}"
        )
        return Sheet(
            name=self.path.stem,
            subject="new file",
            verdict=verdict,
            facts={"file": str(self.path)},
        )

    def report(self, out: str | Path | None = None, *, force: bool = False, **_: object) -> Path:
        """Write the file and return its path; nothing for the list of templates.

        Raises OutputExistsError where the file exists and `force` is not set, LostmotionError where
        it cannot be written.
        """
        target = self.path if out is None else Path(out)
        if target is None or self.path is None:
            return Path()
        try:
            with target.open("w" if force or self.force else "x", encoding="utf-8") as stream:
                stream.write(self.text)
        except FileExistsError as error:
            raise OutputExistsError(
                f"'{target}' exists\n  replace it with --force (force=True in Python), or name "
                "another file with --out"
            ) from error
        except OSError as error:
            raise LostmotionError(
                f"'{target}' could not be written: {error.strerror or error}\n  name another "
                "file with --out"
            ) from error
        return target

    def outcome(self, written: Path) -> str:
        """Return the line that names the file; empty for the list of templates."""
        return f"File: {written}" if self.path is not None else ""


@question(folder="")
def new(
    name: Annotated[
        str | None,
        Argument(
            "Name of the arm; the file is NAME.toml. Default: the name of the template.",
            metavar="NAME",
        ),
    ] = None,
    *,
    template: Annotated[Template, Argument("Kind of arm to start from.")] = "six-axis",
    urdf: Annotated[
        "str | Path | None",
        Argument(
            (
                "Write the sidecar of this URDF, xacro, MJCF or SDF file instead: the class of its "
                "drives, the load of each, and fitting reducers."
            ),
            path_of,
            metavar="URDF",
            aliases=("--from",),
        ),
    ] = None,
    tip: Annotated[
        str | None,
        Argument(
            (
                "Link that is the tool, with --from. Default: that of the sidecar or SRDF, else "
                "by its name."
            ),
            metavar="LINK",
        ),
    ] = None,
    templates: Annotated[
        bool, Argument("List the templates and write nothing.", aliases=("--list",))
    ] = False,
    out: Annotated[
        "str | Path | None",
        Argument(
            "File to write. Default: NAME.toml, or the sidecar's place beside the URDF.",
            path_of,
            metavar="TOML",
        ),
    ] = None,
    force: Annotated[bool, Argument("Replace an existing file.")] = False,
) -> New:
    """Begin an arm file that runs at once: from a template, or the sidecar of a URDF, with every
    assumed value marked.

    Raises
    ------
    InputError
        With every mistake in the arguments and the URDF.

    """
    asked = read_arguments(new, locals())
    if asked.tip is not None and asked.urdf is None:
        raise refuse_argument(
            "tip, urdf",
            f"the tool '{asked.tip}' of no file",
            "a URDF, xacro, MJCF or SDF file, whose link it is",
            urdf="arm.urdf",
            tip=asked.tip,
        )
    from lostmotion.io.arm_templates import template_text

    kinds, name = get_args(Template), (asked.name or "").removesuffix(".toml")
    if asked.name and not name:
        raise refuse_argument("name", asked.name, "the name of an arm", name="my-arm")
    if asked.templates:
        return New("", None, kinds)
    if asked.urdf is not None:
        from lostmotion.io.first_sidecar import first_sidecar
        from lostmotion.io.sidecar import sidecar_place

        target = Path(f"{name}.toml") if name else sidecar_place(asked.urdf)
        return New(
            first_sidecar(asked.urdf, asked.tip),
            asked.out or target,
            kinds,
            asked.urdf,
            force=asked.force,
        )
    return New(
        template_text(asked.template, name),
        asked.out or Path(f"{name or asked.template}.toml"),
        kinds,
        force=asked.force,
    )
