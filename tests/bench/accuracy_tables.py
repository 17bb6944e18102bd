#!/usr/bin/env python3
"""What accuracy costs in scenes of ours, as the page docs/measurements/accuracy.md.

accuracy_tables.py PROGRAM [--size WxH] [--budget SECONDS] [SCENE...] prints the page: `PROGRAM bench accuracy` is run for each
scene (courtyard, cathedral, glass), with ambient occlusion on so that its rays have a price too."""

import argparse
import json
import subprocess

SETTING = "ambientOcclusion=on"


def measured(program, scene, size, budget):
    command = [program, "bench", "accuracy", scene, "--device", "embree", "--set", SETTING, "--size", size, "--budget", str(budget)]
    return json.loads(subprocess.run(command + ["--json"], check=True, stdout=subprocess.PIPE).stdout)


def percent(share):
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def section(result):
    reference, light, model = result["reference"], result["light_reference"], result["model"]
    lines = [f"## {result['scene']}", ""]
    lines += [f"- {result['width']}x{result['height']}, {result['device']}",
              f"- reference: {reference['samples']} samples, own error {percent(reference['rmse'])}",
              f"- all light: {light['samples']} samples, own error {percent(light['rmse'])}; the view without a",
              f"  limit is {percent(model['rmse'])} from it, its mean {100 * model['bias']:+.1f} %"]
    if result["samples_slope"] is not None:
        lines += [f"- slope of error against samples: {result['samples_slope']:.2f}"]
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
        lines += [f"- {row['ms_median']:.3g} ms, {percent(row['rmse'])}:", f"  {what}"]
    lines += ["", "Not turned:", ""]
    lines += [f"- `{knob['knob']}`: {knob['why']}"[:100] for knob in result["not_turned"]]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="*", default=["courtyard", "cathedral", "glass"])
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--budget", type=float, default=120)
    options = parser.parse_args()
    lines = ["# What accuracy costs in scenes", "",
             f"Made by `tests/bench/accuracy_tables.py PROGRAM --size {options.size} --budget {options.budget:g}`,",
             f"with `{SETTING}`. What the columns are:",
             "[definitions](../reference/accuracy.md#how-errors-are-measured), method:",
             "[bench accuracy](../reference/benchmarks.md#bench-accuracy). Times are of a picture of 16 samples",
             "where nothing else is said.", "",
             "- `*`: as given", "- `<=`: no more than twice the reference's own error, so it may be anything smaller",
             "- `L`: against all light, by the path integrator",
             "- `jpegQuality`: time and error of coding alone", ""]
    for scene in options.scenes:
        lines += section(measured(options.program, scene, options.size, options.budget)) + [""]
    print("\n".join(lines).rstrip())


if __name__ == "__main__":
    main()
