#!/usr/bin/env python3
"""What accuracy costs in scenes of ours, as the page docs/measurements/accuracy.md.

accuracy_tables.py PROGRAM [--size WxH] [--budget SECONDS] [--plots FOLDER] [SCENE...] prints the page: `PROGRAM bench accuracy` is
run for each scene (courtyard, cathedral, glass), with ambient occlusion on so that its rays have a price too. The plots of its
reports go into FOLDER, as accuracy_SCENE.svg. With --from FOLDER, SCENE.json and SCENE.html of runs elsewhere are taken from there."""

import argparse
import json
import os
import re
import subprocess
import tempfile
import textwrap

SETTING = "ambientOcclusion=on"


PLACE = "../images"  # of the plots, seen from the page
STYLE = """svg{background:#fbfbfa;font:12px system-ui,sans-serif}text{fill:#5c636b}.mid{text-anchor:middle}.end{text-anchor:end}
.grid{stroke:#dcdedf}polyline{fill:none}.front{stroke:#0b62c4;stroke-width:2}.samples{stroke:#c2410c;stroke-width:1.5}
.half{stroke:#5c636b;stroke-dasharray:6 4}.bound{stroke:#5c636b;stroke-dasharray:2 3}circle.one{fill:#5c636b}
circle.tried{fill:none;stroke:#5c636b}circle.best{fill:#0b62c4}circle.given{fill:none;stroke:#c2410c;stroke-width:2.5}"""


def measured(program, scene, size, budget, folder):
    """Leaves SCENE.json and SCENE.html in the folder."""
    command = [program, "bench", "accuracy", scene, "--device", "embree", "--set", SETTING, "--size", size, "--budget", str(budget)]
    with open(os.path.join(folder, scene + ".json"), "w", encoding="utf-8") as file:
        subprocess.run(command + ["--json", "--report", os.path.join(folder, scene + ".html")], check=True, stdout=file)


def plot(report):
    """The report's plot as a picture of its own."""
    svg = re.search(r"<svg (.*?)>(.*)</svg>", report, re.S)
    return f"<svg xmlns='http://www.w3.org/2000/svg' {svg[1]}>\n<style>{STYLE}</style>{svg[2]}</svg>\n"


def percent(share):
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def section(result, plotted):
    reference, light, model = result["reference"], result["light_reference"], result["model"]
    lines = [f"## {result['scene']}", ""]
    lines += [f"- {result['width']}x{result['height']}, {result['device']}",
              f"- reference: {reference['samples']} samples, own error {percent(reference['rmse'])}",
              f"- all light: {light['samples']} samples, own error {percent(light['rmse'])}; the view without a",
              f"  limit is {percent(model['rmse'])} from it, its mean {100 * model['bias']:+.1f} %"]
    if result["samples_slope"] is not None:
        lines += [f"- slope of error against samples: {result['samples_slope']:.2f}"]
    if plotted:
        lines += ["", f"![Error against time: {result['scene']}]({PLACE}/accuracy_{result['scene']}.svg)"]
    lines += ["", "| knob | value | ms | error | bias | from exact | PSNR dB | FLIP |",
              "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for row in result["rows"]:
        if row["knob"] == "combination":
            continue
        value = row["value"] + (" *" if row["given"] else "")
        if row["against"] == "uncoded":
            figures = ["", "", ""]
        else:
            bound = "<= " if row["at_bound"] else ""
            own = row["from_exact"]
            figures = [bound + percent(row["rmse"]) + (" L" if row["against"] == "light" else ""), f"{100 * row['bias']:+.2f} %",
                       "" if own is None else percent(own)]
        cells = [row["knob"], value, f"{row['ms_median']:.3g}", *figures, f"{row['psnr_db']:.1f}", f"{row['flip']:.3f}"]
        lines += ["| " + " | ".join(cells) + " |"]
    lines += ["", "Front, from fast to exact:", ""]
    for index in result["pareto"]:
        row = result["rows"][index]
        what = "`" + "`, `".join(row["set"]) + "`" if row["set"] else "as given"
        lines += [f"- {row['ms_median']:.3g} ms, {percent(row['rmse'])}:"]
        lines += textwrap.wrap(what, 98, initial_indent="  ", subsequent_indent="  ")
    lines += ["", "Not turned:", ""]
    lines += [f"- `{knob['knob']}`: {knob['why']}"[:100] for knob in result["not_turned"]]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", default=["courtyard", "cathedral", "glass"])
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--budget", type=float, default=120)
    parser.add_argument("--plots")
    parser.add_argument("--from", dest="runs")
    options = parser.parse_args()
    lines = ["# What accuracy costs in scenes", "",
             f"Made by `tests/bench/accuracy_tables.py PROGRAM --size {options.size} --budget {options.budget:g}`,",
             f"with `{SETTING}`. What the columns are:",
             "[definitions](../reference/accuracy.md#how-errors-are-measured), method:",
             "[bench accuracy](../reference/benchmarks.md#bench-accuracy). Times are of a picture of 16 samples",
             "where nothing else is said. Plots: dots are settings, filled ones the front, the ring is what was",
             "given, the orange line samples alone, dashes the slope of independent samples.", "",
             "- `*`: as given", "- `<=`: no more than twice the reference's own error, so it may be anything smaller",
             "- `L`: against all light, by the path integrator",
             "- `jpegQuality`: time and error of coding alone", ""]
    with tempfile.TemporaryDirectory() as own:
        folder = options.runs or own
        for scene in options.scenes:
            if not options.runs:
                measured(options.program, scene, options.size, options.budget, folder)
            with open(os.path.join(folder, scene + ".json"), encoding="utf-8") as file:
                lines += section(json.load(file), options.plots) + [""]
            if options.plots:
                with open(os.path.join(folder, scene + ".html"), encoding="utf-8") as report:
                    with open(os.path.join(options.plots, f"accuracy_{scene}.svg"), "w", encoding="utf-8") as picture:
                        picture.write(plot(report.read()))
    print("\n".join(lines).rstrip())


if __name__ == "__main__":
    main()
