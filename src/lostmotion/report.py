"""The report of a study: a folder with report.html, result.json and arrays.nc, written whole or not at all; and tables for notebooks."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
import secrets
import stat
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import LostmotionError, OutputExistsError
from lostmotion.figures import Figure, Row, Section, result, sections

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.plots import Plot
    from lostmotion.studies.answer import Answer

FILES: Final = ("report.html", "result.json", "arrays.nc")

_TABLES_CSS: Final = """
div.lostmotion{background:#fff;color:#222;padding:4px 8px}
div.lostmotion table{max-width:760px;margin:0 0 16px}
.lostmotion table{border-collapse:collapse;font-size:13px;line-height:1.35;font-variant-numeric:tabular-nums;width:100%;text-align:left}
.lostmotion caption{text-align:left;font-weight:600;font-size:14px;padding:0 0 6px;color:#222}
.lostmotion th,.lostmotion td{padding:4px 10px 4px 0;vertical-align:top;text-align:left;border:0;background:none}
.lostmotion th:last-child,.lostmotion td:last-child{padding-right:0}
.lostmotion thead tr>*{font-weight:600;color:#444;border-bottom:1px solid #888;vertical-align:bottom}
.lostmotion tbody th{font-weight:400;overflow-wrap:anywhere;min-width:10em}
.lostmotion tbody tr+tr>*{border-top:1px solid #e6e6e6}
.lostmotion td.value{text-align:right;white-space:nowrap;font-weight:600}
.lostmotion thead th.value{text-align:right}
.lostmotion .interval{white-space:nowrap}
.lostmotion td.interval{color:#555}
.lostmotion small{display:block;color:#666;font-size:11.5px;overflow-wrap:anywhere}
.lostmotion sup{color:#777;font-weight:400;font-size:9.5px;line-height:0;margin-left:1px}
.lostmotion tfoot td{color:#666;font-size:11.5px;padding-top:6px;border-top:1px solid #888}
"""
_PAGE_CSS: Final = """
*{box-sizing:border-box}
body{margin:0 auto;max-width:1320px;padding:28px 32px 48px;background:#fff;color:#222;font:15px/1.5 FONT}
h1{font-size:26px;line-height:1.2;margin:0 0 6px;overflow-wrap:anywhere}
h2{font-size:19px;margin:0 0 14px;padding-top:14px;border-top:2px solid #222}
p{margin:0 0 10px;max-width:80ch;overflow-wrap:anywhere}
a{color:#0b5394}
.verdict{font-size:17px}
nav{font-size:13.5px;margin:0 0 20px;color:#666}
nav a{margin-right:14px;white-space:nowrap}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(170px,1fr));gap:12px;margin:18px 0 16px;padding:0}
.cards div{border:1px solid #ccc;border-radius:4px;padding:10px 12px;margin:0}
.cards dt{font-size:12.5px;color:#444}
.cards dd{margin:0}
.cards .number{font-size:22px;font-weight:600;line-height:1.35;font-variant-numeric:tabular-nums}
.cards .quiet{font-size:12px;color:#666;overflow-wrap:anywhere}
section{margin:34px 0 0}
section caption{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%)}
.pair{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,1fr);gap:26px 36px;align-items:start}
.table{overflow-x:auto}
figure{margin:0;min-width:0;max-width:660px;width:100%}
.warn{border-left:3px solid #b23a00;padding-left:10px}
dl.words{display:grid;grid-template-columns:max-content 1fr;gap:5px 18px;margin:0;font-size:14px;max-width:100ch}
dl.words dt{font-weight:600}
dl.words dd{margin:0}
@media (max-width:1000px){body{padding:20px 18px 36px}.pair{grid-template-columns:minmax(0,1fr)}}
@media (max-width:560px){dl.words{grid-template-columns:1fr;gap:0}dl.words dd{margin-bottom:8px}}
@page{size:A4;margin:16mm 15mm}
@media print{
body{padding:0;max-width:none;font-size:10.5pt}
nav,.modebar{display:none!important}
.pair{display:block}
figure{margin:10px auto 0;break-inside:avoid}
.table{overflow:visible;break-inside:avoid}
tr,.cards div,dl.words dd,#words,#source{break-inside:avoid}
.lostmotion tfoot{display:table-row-group}
h2{break-after:avoid}
section{margin-top:22px}
}
"""
_DRAW: Final = """
for (const block of document.querySelectorAll('script[type="application/json"]')) {
  const plot = JSON.parse(block.textContent);
  Plotly.newPlot("plot-" + block.dataset.plot, plot.data, plot.layout, {
    responsive: true, displaylogo: false, showSendToCloud: false, plotlyServerURL: "",
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    toImageButtonOptions: {format: "svg", filename: block.dataset.plot},
  });
}
"""
# What the words mean, for whoever reads the report without the manual.
_WORDS: Final = (
    ("position error", "distance between the point the tool was sent to and the point it reaches."),
    (
        "design, robot, visit",
        "where an error comes from: load and pose, alike in every arm of this design; how one robot was built; one visit of a pose to the next.",
    ),
    ("AP", "pose accuracy of ISO 9283: how far the average of a robot's visits lies from the commanded point. Predicted here, not certified."),
    ("RP", "pose repeatability of ISO 9283: how far its visits scatter about their own average, mean plus three standard deviations."),
    ("interval", "95 % confidence. It counts robots and independent sets of poses, never single samples. A question mark: too few of them to tell."),
    ("share", "of the mean-square error. Shares add to 100 %; a negative one cancels part of the others, so that the arm would be worse without it."),
    ("first order", "errors are small and are added up. The last table composes a sample of them exactly and shows the difference."),
)


def write_folder(study: Answer, out: str | Path, *, force: bool = False) -> Path:
    """Where do the results lie? Writes report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

    Missing parents are made. With `force` an earlier output folder is replaced, once the new one is complete. The same study gives the same bytes.
    Raises OutputExistsError as `refuse_existing`, LostmotionError where the folder cannot be written; then nothing is left behind.
    """
    target = refuse_existing(out, force=force)
    contents = _contents(study)
    made: list[Path] = []
    try:
        for parent in reversed([parent for parent in target.parents if not parent.exists()]):
            parent.mkdir()
            made.append(parent)
        _place(contents, target, force=force)
    except BaseException as error:
        for parent in reversed(made):
            _remove_if_empty(parent)
        if isinstance(error, OSError):
            raise LostmotionError(
                f"'{target}' could not be written: {error.strerror or error}\n  nothing was left behind; name a folder that can be written with --out"
            ) from error
        raise
    return target


def refuse_existing(out: str | Path, *, force: bool) -> Path:
    """May results be written to this folder? Gives it as an absolute path.

    Raises OutputExistsError where something is there already: a file or a link always, a folder unless `force` is set and it holds only our files.
    """
    target = Path(out)
    target = target.absolute() if target.name not in {"", ".."} else target.resolve()
    try:
        kind = target.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return target
    except OSError as error:
        raise LostmotionError(f"'{target}' cannot be looked at: {error.strerror}") from error
    if stat.S_ISLNK(kind):
        raise OutputExistsError(f"'{target}' is a symbolic link, which is never replaced\n  name the folder itself, or another one, with --out")
    if not stat.S_ISDIR(kind):
        raise OutputExistsError(f"'{target}' is a file, and results go into a folder\n  name another folder with --out")
    strangers = _strangers(target)
    if strangers:
        more = f" and {len(strangers) - 3} more" if len(strangers) > 3 else ""  # noqa: PLR2004 - enough to recognise the folder
        names = ", ".join(repr(name) for name in strangers[:3]) + more
        raise OutputExistsError(
            f"'{target}' exists and holds files that are not ours: {names}\n  it is left alone, even with --force; name another folder with --out"
        )
    if target.resolve() == Path.cwd():
        raise OutputExistsError(f"'{target}' is the folder you stand in, which is never replaced\n  name another folder with --out")
    if not force:
        raise OutputExistsError(f"'{target}' exists\n  replace it with --force (force=True in Python), or name another folder with --out")
    return target


def tables_html(answer: Answer) -> str:
    """Show every figure of a study in a notebook: its tables as compact HTML that needs nothing else."""
    found = sections(answer)
    tables = "".join(_table(section) for section in found)
    return f'<div class="lostmotion"><style>{_TABLES_CSS}</style><p><b>{_text(answer.arm.name)}</b><br>{_text(_verdict(found))}</p>{tables}</div>'


def _strangers(folder: Path) -> list[str]:
    """Name the entries of a folder that we did not write."""
    return sorted(entry.name for entry in os.scandir(folder) if entry.name not in FILES or not entry.is_file(follow_symlinks=False))


def _contents(study: Answer) -> dict[str, bytes]:
    """Make everything in memory, so that what fails to be made never reaches the disk."""
    from lostmotion import __version__
    from lostmotion.arrays import dataset

    plain = json.dumps(result(study, __version__), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    return {
        "report.html": _page(study, __version__).encode(),
        "result.json": f"{plain}\n".encode(),
        "arrays.nc": bytes(dataset(study).to_netcdf(engine="scipy")),
    }


def _place(contents: Mapping[str, bytes], target: Path, *, force: bool) -> None:
    """Write a new folder beside the target and put it in its place by renaming; the old one goes last."""
    token = secrets.token_hex(4)
    new, old = (target.with_name(f".{target.name[:80]}.{token}.{state}") for state in ("new", "old"))
    new.mkdir()
    try:
        for name, content in contents.items():
            (new / name).write_bytes(content)
        refuse_existing(target, force=force)  # it may have come into being meanwhile
        if not target.exists():
            new.rename(target)
            return
        target.rename(old)
        try:
            new.rename(target)
        except BaseException:
            old.rename(target)
            raise
    except BaseException:
        _remove(new)
        raise
    try:
        _remove(old)
    except OSError as error:
        raise LostmotionError(f"'{target}' is written, but the earlier folder could not be removed: '{old}' ({error.strerror})") from error


def _remove(folder: Path) -> None:
    """Take away a folder of ours: our files by name and nothing else."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
    _remove_if_empty(folder)


def _remove_if_empty(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError:
        return  # someone put something into it: theirs to keep


def _page(answer: Answer, version: str) -> str:
    """Lay out report.html: verdict, key figures, sections with their plots, what the words mean, where it came from. No request leaves it."""
    from plotly.offline import get_plotlyjs

    from lostmotion.plots import FONT, plots

    found = sections(answer)
    drawn = plots(answer)
    library = get_plotlyjs().replace("</script", "<\\/script")
    allowed = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()}'" for code in (library, _DRAW))
    policy = f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: blob:"
    name = _text(answer.arm.name)
    links = " ".join(f'<a href="#{section.key}">{_text(section.title)}</a>' for section in found)
    notes = "".join(f'<p class="warn">{_text(note)}</p>' for note in answer.arm.notes)
    words = "".join(f"<dt>{word}</dt><dd>{meaning}</dd>" for word, meaning in _WORDS)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}: predicted accuracy</title>
<style>{_PAGE_CSS.replace("FONT", FONT)}{_TABLES_CSS}</style>
</head>
<body class="lostmotion">
<header>
<h1>{name}</h1>
<p class="verdict">{_text(_verdict(found))}</p>
{notes}
<nav aria-label="Sections">{links}<a href="#words">How to read this</a></nav>
<dl class="cards">{"".join(_cards(found))}</dl>
</header>
<main>
{"".join(_section(section, [plot for plot in drawn if plot.section == section.key]) for section in found)}
<section id="words"><h2>How to read this</h2><dl class="words">{words}</dl></section>
</main>
<footer>
<section id="source"><h2>Where it comes from</h2><p>{_text(_source(answer, version))}</p>
<p>Beside this page lie the same figures as plain data, <a href="result.json">result.json</a>,
and what was found for every pose and robot, <a href="arrays.nc">arrays.nc</a> (NetCDF).</p></section>
</footer>
<noscript><p>The plots need JavaScript; every figure is in the tables.</p></noscript>
<script>{library}</script>
{"".join(_data(plot) for plot in drawn)}<script>{_DRAW}</script>
</body>
</html>
"""


def _verdict(found: list[Section]) -> str:
    """Say in a sentence or three what the user asked: how far off, which part is dearest, how well it repeats."""
    error = _row(found, "error", "95 % below")
    said = []
    if error is not None:
        figure = error.figures[0]
        said.append(f"Expect 95 % of positions within {figure}{f' ({figure.interval})' if figure.interval else ''}.")
    parts = next((section.rows for section in found if section.key == "budget"), ())
    if parts and parts[0].figures[1].value > 0:
        said.append(f"The dearest part is {parts[0].label} with {parts[0].figures[1]} of the mean-square error.")
    repeats = _row(found, "iso9283", "RP, 95 % of robots below")
    if repeats is not None:
        said.append(f"95 % of the robots built repeat within {repeats.figures[0]}.")
    return " ".join(said)


def _cards(found: list[Section]) -> list[str]:
    """Show the six figures that are asked for first, each with its interval."""
    wanted = (
        ("95 % of positions within", "error", "95 % below"),
        ("mean position error", "error", "mean"),
        ("accuracy AP, 95 % of robots within", "iso9283", "AP, 95 % of robots below"),
        ("repeatability RP, 95 % of robots within", "iso9283", "RP, 95 % of robots below"),
        ("reach from the base", "workspace", "reach from the base"),
    )
    rows = [(title, _row(found, section, label)) for title, section, label in wanted]
    cards = [
        _card(title, str(row.figures[0]), f"interval {row.figures[0].interval}" if row.figures[0].interval else row.note)
        for title, row in rows
        if row is not None
    ]
    parts = next((section.rows for section in found if section.key == "budget"), ())
    if parts:
        cards.append(_card("dearest part, share of mean square", str(parts[0].figures[1]), parts[0].label))
    return cards


def _card(title: str, number: str, quiet: str) -> str:
    return f'<div><dt>{_text(title)}</dt><dd class="number">{_text(number)}</dd><dd class="quiet">{_text(quiet)}</dd></div>'


def _row(found: list[Section], key: str, label: str) -> Row | None:
    return next((row for section in found if section.key == key for row in section.rows if row.label == label), None)


def _section(section: Section, drawn: list[Plot]) -> str:
    figures = "".join(f'<figure role="img" aria-label="{_text(plot.words)}"><div id="plot-{plot.key}"></div></figure>' for plot in drawn)
    table = _table(section)
    return f'<section id="{section.key}"><h2>{_text(section.title)}</h2><div class="pair"><div class="table">{table}</div>{figures}</div></section>\n'


def _table(section: Section) -> str:
    """Set a section as a table: label and remark, each figure with its interval, and below what they were counted from."""
    if not section.rows:
        return f"<p>{_text(section.title)}: {_text(section.note)}</p>"
    samples = list(dict.fromkeys(figure.samples for row in section.rows for figure in row.figures if figure.samples))
    with_interval = [any(row.figures[k].interval for row in section.rows) for k in range(len(section.columns))]
    head = "".join(
        f'<th scope="col" class="value">{_text(name)}</th>' + ('<th scope="col" class="interval">95 % interval</th>' if interval else "")
        for name, interval in zip(section.columns, with_interval, strict=True)
    )
    body = []
    for row in section.rows:
        note = f"<small>{_text(row.note)}</small>" if row.note else ""
        cells = "".join(_cells(figure, samples, interval=interval) for figure, interval in zip(row.figures, with_interval, strict=True))
        body.append(f'<tr><th scope="row">{_foldable(row.label)}{note}</th>{cells}</tr>')
    quiet = [_text(section.note)] if section.note else []
    quiet += [f"{f'<sup>{_mark(k)}</sup> ' if len(samples) > 1 else ''}from {_text(text)}" for k, text in enumerate(samples)]
    foot = f'<tfoot><tr><td colspan="{1 + len(section.columns) + sum(with_interval)}">{"<br>".join(quiet)}</td></tr></tfoot>' if quiet else ""
    return f"<table><caption>{_text(section.title)}</caption><thead><tr><td></td>{head}</tr></thead><tbody>{''.join(body)}</tbody>{foot}</table>"


def _cells(figure: Figure, samples: list[str], *, interval: bool) -> str:
    mark = f"<sup>{_mark(samples.index(figure.samples))}</sup>" if len(samples) > 1 and figure.samples else ""
    return f'<td class="value">{_text(str(figure))}{mark}</td>' + (f'<td class="interval">{_text(figure.interval)}</td>' if interval else "")


def _mark(index: int) -> str:
    return chr(ord("a") + index)


def _source(answer: Answer, version: str) -> str:
    sampled, poses = answer.sampled, answer.poses
    sets = f" in {poses.replicates} independent sets" if poses.replicates > 1 else ""
    arriving = "from either side at random" if answer.approach == 0 else "moving up" if answer.approach > 0 else "moving down"
    samples = len(poses) * sampled.robots * sampled.visits
    counts = f"{len(poses)} poses ({poses.law}){sets} x {sampled.robots} robots x {sampled.visits} visits = {samples} samples"
    return (
        f"lostmotion {version}, seed {answer.seed}: {counts}; joints arrive {arriving}. The same arm, version, seed and counts give the same bytes."
    )


def _data(plot: Plot) -> str:
    """Hold a plot's data as JSON that no text in it can break out of."""
    plain: dict[str, Any] = json.loads(plot.figure.to_json())
    text = json.dumps({"data": plain["data"], "layout": plain["layout"]}, separators=(",", ":"), sort_keys=True)
    for char in "&<>":
        text = text.replace(char, f"\\u{ord(char):04x}")
    return f'<script type="application/json" data-plot="{plot.key}">{text}</script>\n'


def _foldable(name: str) -> str:
    """Let a long name of a part fold at its joints, not in mid-word."""
    return re.sub(r"([._])(?=\w{3})", r"\1<wbr>", _text(name))


def _text(text: str) -> str:
    return html.escape(text)
