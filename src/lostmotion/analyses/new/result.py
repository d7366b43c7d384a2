"""Result of `new`: the text of a file to begin with, or the list of templates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.analyses.signature import results_folder
from lostmotion.errors import LostmotionError, OutputExistsError
from lostmotion.reporting.sheet import Row, Section, Sheet, in_words

if TYPE_CHECKING:
    from collections.abc import Sequence


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
        if self.path is None:
            from lostmotion.io.arm_templates import template_summary

            rows = tuple(Row(each, (in_words(template_summary(each)),)) for each in self.templates)
            text = "lostmotion new my-arm --template scara"
            return Sheet(
                name="templates",
                subject="templates",
                verdict=text,
                cards=(),
                sections=(Section("templates", "Templates", ("value",), rows),),
                source="",
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
            cards=(),
            sections=(),
            source="",
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
