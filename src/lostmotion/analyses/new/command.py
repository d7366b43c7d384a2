"""Begin an arm file from a template, or a sidecar from a URDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

from lostmotion.analyses.arguments import path_of
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from lostmotion.analyses.new.result import New

Template = Literal["z-arm", "six-axis", "scara", "gantry", "hobby", "palletiser"]


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
                "Write the sidecar of this URDF, xacro or MJCF file instead: the class of its "
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
            "a URDF, xacro or MJCF file, whose link it is",
            urdf="arm.urdf",
            tip=asked.tip,
        )
    from lostmotion.analyses.new.result import New
    from lostmotion.io.arm_templates import template_text

    kinds = get_args(Template)
    if asked.templates:
        return New("", None, kinds)
    if asked.urdf is not None:
        from lostmotion.io.first_sidecar import first_sidecar
        from lostmotion.io.sidecar import sidecar_place

        target = sidecar_place(asked.urdf) if asked.name is None else Path(f"{asked.name}.toml")
        return New(
            first_sidecar(asked.urdf, asked.tip),
            asked.out or target,
            kinds,
            asked.urdf,
            force=asked.force,
        )
    stem = asked.name or asked.template
    return New(
        template_text(asked.template, asked.name or ""),
        asked.out or Path(f"{stem}.toml"),
        kinds,
        force=asked.force,
    )
