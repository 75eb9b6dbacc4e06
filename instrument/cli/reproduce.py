"""``kinopix reproduce``: the paper's tables and figures, simulated and processed anew."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.choices import Reproduced
from instrument.cli.options import JsonOption, SchedulerOption, WorkersOption, print_json

if TYPE_CHECKING:
    from instrument.studies import Result
    from instrument.workers import Where


def reproduce_paper(
    what: Annotated[Reproduced, typer.Argument(metavar="STUDY", help="One table or figure of the paper, or all.")],
    out: Annotated[
        Path, typer.Option("--out", help="Folder for figures, numbers, and the points that are finished.")
    ] = Path("results"),
    seeds: Annotated[
        int | None, typer.Option(min=1, max=1000, help="Number of seeds; 5 for table 1 and 3 else if not given.")
    ] = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    docs: Annotated[
        Path | None, typer.Option(help="Folder for a page of the documents on each study, with its pictures.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate what the paper measured, process it as published and by our own analysis, and hold both against its figures.

    Points that are finished are kept in the folder: after Ctrl-C, or a kill, the same command goes on from there.
    """
    from instrument.studies import STUDIES
    from instrument.views import OUT, claims_table, picture_folder, say, study_tables, write_csv, write_study_pictures
    from instrument.workers import Where
    from protocols import KinopixError

    studies = list(STUDIES.values()) if what == "all" else [STUDIES[what]]
    picture_folder(out)
    results = _carried_out([study.name for study in studies], out / "points", seeds, Where.of(workers, scheduler))
    table: dict[str, object] = {}
    for result in results:
        written = [*write_csv(result, out), *write_study_pictures(result, out)]
        if docs is not None:
            write_study_pictures(result, picture_folder(docs), pdf=False)
            _write_page(result, docs)
        if as_json:
            table[result.study.name] = _as_json(result)
            continue
        say(f"\n{result.study.title}. Mean ± deviation of one seed, seeds 0 to {result.seeds - 1}\n")
        for each in (*study_tables(result), claims_table(result)):
            OUT.print(each)
        for path in written:
            say(f"written {path}")
    if as_json:
        print_json(table)
    failed = {name: why for result in results for name, why in result.failures.items()}
    if failed:
        raise KinopixError(
            saw=f"{len(failed)} points fail: " + "; ".join(f"{name} ({why})" for name, why in failed.items()),
            expected="all points computed; the tables above are those of the others",
            remedy="look at the reasons, then give the same command: it computes what is missing",
        )


def _carried_out(names: list[str], folder: Path, seeds: int | None, where: "Where") -> "list[Result]":
    """Compute all points under a progress bar, and say what is kept if somebody interrupts it."""
    from instrument.studies import STUDIES, reproduce
    from instrument.views import progress

    studies = [study for study in STUDIES.values() if study.name in names]
    counts = [0, 0]
    with progress() as bars:
        task = bars.add_task("points", total=None)

        def tell(name: str, done: int, total: int) -> None:
            counts[:] = done, total
            bars.update(task, description=name, completed=done, total=total)

        try:
            return reproduce(
                studies,
                folder,
                seeds=seeds,
                workers=where.processes,
                scheduler=where.scheduler,
                on_point=lambda point, done, total: tell(point.name, done, total),
            )
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(
                f"{counts[0]} finished points are kept in {folder}, and the same command goes on from there"
            )
            raise


def _write_page(result: "Result", docs: Path) -> None:
    """Write the page of a study, and the index of all to a folder that has none."""
    from instrument.studies import STUDIES
    from instrument.views import study_index, study_page

    name = result.study.name
    page = study_page(result, [f"{name}.png", f"{name}-images.png"])
    (docs / f"{name}.md").write_text(page, encoding="utf-8")
    index = docs / "README.md"
    if not index.exists():
        index.write_text(study_index([(study.name, study.title) for study in STUDIES.values()]), encoding="utf-8")


def _as_json(result: "Result") -> dict[str, object]:
    return {
        "seeds": result.seeds,
        "figures": [
            {
                "case": label,
                "processing": processing,
                "figure": metric,
                "mean": spread.mean,
                "deviation": spread.deviation,
            }
            for (label, processing, metric), spread in result.summary.spreads.items()
        ],
        "claims": [{"text": claim.text, "holds": claim.holds} for claim in result.study.claims(result.summary)],
        "failures": dict(result.failures),
    }
