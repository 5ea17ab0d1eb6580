# SPDX-License-Identifier: Apache-2.0
"""What to set: a table for each dial, the Pareto front, and the cheapest or best setting."""
import math

# of a cost: its name, and what an axis says
COSTS = {"cpu_s": ("time", "CPU seconds of all stages, one thread"),
         "bytes": ("bytes", "bytes of the baked stream, binary"),
         "probes": ("probes", "probes")}


def front(rows, cost):
    """The Pareto front: rows that no other beats in both, cheapest first. Costs as near as three
    digits are the same: a header has a few bytes more for a larger number."""
    best, kept = math.inf, []
    for row in sorted(rows, key=lambda r: (float(f"{r[cost]:.3g}"), r["error"])):
        if row["error"] < best:
            best = row["error"]
            kept.append(row)
    return kept


def amount(x):
    for unit, size in (("MB", 1e6), ("kB", 1e3)):
        if x >= size:
            return f"{x / size:.3g} {unit}"
    return f"{x:.0f} B"


def interval(row):
    return f"{row['error_low']:.2%} to {row['error_high']:.2%}"


def describe(row):
    within = f" ({interval(row)})" if "error_low" in row else ""
    return (f"{row['run']}: {row['error']:.2%}{within}, {row['cpu_s']:.3g} CPU s,"
            f" {amount(row['bytes'])}, {row['probes']} probes")


def series_of(sweep, rows, dial):
    """The runs where this dial alone differs from base, in the order of the sweep file."""
    base = [r for r in rows if r["settings"] == sweep.base]
    order = [sweep.base[dial]] + sweep.vary[dial]
    if sweep.base[dial] in sweep.vary[dial]:
        order = sweep.vary[dial]
    return sorted(base + [r for r in rows if dial in r["dials"] and r not in base],
                  key=lambda r: order.index(r["settings"][dial]))


def print_table(table):
    widths = [max(len(line[i]) for line in table) for i in range(len(table[0]))]
    for first, *others in table:
        cells = [cell.rjust(w) for cell, w in zip(others, widths[1:])]
        print("  " + "  ".join([first.ljust(widths[0])] + cells))


def dial_tables(sweep, rows):
    """Of each dial a table, and where it stops paying: the cheapest value within 5 % of the least
    error that the dial gets."""
    sizes = [f"{s[0]}_bytes" for s in sweep.sizes]
    for dial in sweep.vary:
        series = series_of(sweep, rows, dial)
        if len(series) < 2:
            continue
        print(f"\n{dial} (base: {sweep.base[dial] or 'none'})")
        table = [("value", "CPU s", "probes", "size", *sizes, "error", "95 %", "seen", "rms",
                  "leaked", "bias")]
        for r in series:
            seen, rms, leaked, bias = (
                float(r["figures"].get(name, "nan"))
                for name in ("error_seen", "rms_relative", "leaked_rms_relative", "bias_relative"))
            table.append((r["settings"][dial] or "none", f"{r['cpu_s']:.2f}", str(r["probes"]),
                          amount(r["bytes"]), *[amount(r.get(s, math.nan)) for s in sizes],
                          f"{r['error']:.2%}", interval(r) if "error_low" in r else "-",
                          f"{seen:.2%}", f"{rms:.2%}", f"{leaked:.2%}", f"{bias:+.2%}"))
        print_table(table)
        least = min(r["error"] for r in series)
        enough = min((r for r in series if r["error"] <= 1.05 * least),
                     key=lambda r: (r["cpu_s"], r["error"]))
        print(f"  pays up to {enough['settings'][dial] or 'none'}: the cheapest within 5 % of the"
              f" least error here, {least:.2%}")


def least(rows, what):
    return describe(min(rows, key=lambda r: r[what]))


def recommend_under(rows, error):
    """The cheapest settings whose error is below this."""
    good = [r for r in rows if r["error"] <= error]
    if not good:
        print(f"no setting is under {error:.2%}; the nearest is\n  {least(rows, 'error')}")
        return
    sure = [r for r in good if r.get("error_high", r["error"]) <= error]
    for cost, (name, _) in COSTS.items():
        def price(r, cost=cost):
            return r[cost], r["error"]
        best = min(good, key=price)
        print(f"the cheapest under {error:.2%} by {name}:\n  {describe(best)}")
        if best not in sure:
            instead = (f"to be sure take\n  {describe(min(sure, key=price))}" if sure
                       else "none of the runs is sure")
            print(f"  its interval reaches beyond: for other points, {instead}")


def recommend_within(rows, cost, limit, text):
    """The best setting that costs at most this."""
    good = [r for r in rows if r[cost] <= limit]
    if good:
        print(f"the best within {text}:\n  {least(good, 'error')}")
    else:
        print(f"no setting is within {text}; the nearest is\n  {least(rows, cost)}")


def recommend(rows, options):
    print(f"\n{len(rows)} runs, error {options.measure}")
    if not (options.error or options.time or options.size):
        print("the best for the time:")
        for row in front(rows, "cpu_s"):
            print(f"  {describe(row)}")
    if options.error:
        recommend_under(rows, options.error)
    if options.time:
        recommend_within(rows, "cpu_s", options.time, f"{options.time} CPU s")
    if options.size:
        recommend_within(rows, "bytes", options.size, amount(options.size))
