"""The fronts as tables and as a plot."""
import os

import markdown
from training_front import front, knobs, runs

# What may be spent, and its name on an axis.
COSTS = {"seconds": "seconds of training", "work": "work: pixels visited, millions", "peak_mib": "peak memory, MiB",
         "gaussians": "Gaussians", "ply_mib": "size of the .ply, MiB"}
# How far below the best the plots reach; what lies lower is not drawn.
DEPTHS = {"psnr": 6, "ssim": 0.2, "cost": 0.03}
QUALITIES = {"psnr": "test PSNR, dB", "ssim": "test SSIM", "cost": "cost of the training views"}


def panels(by):
    """The fronts that are drawn: what is spent, what is reached. by: seconds or work."""
    return [(by, "psnr"), (by, "ssim"), (by, "cost"), ("peak_mib", "psnr"), ("gaussians", "psnr"), ("ply_mib", "psnr")]


def words(point):
    """What a point is."""
    return f"{point['length']:g}" + (f", {knobs.words_of(point['settings'])}" if point["settings"] else "")


def spread(point, figure):
    """Mean and standard deviation, as text."""
    places = {"psnr": 2, "ssim": 4, "gaussians": 0, "iterations": 0, "cost": 5}.get(figure, 1)
    deviation = point[f"{figure}_sd"]
    return f"{point[figure]:.{places}f}" + ("" if deviation is None else f" ± {deviation:.{places}f}")


def front_table(points, x, y):
    figures = [figure for figure in runs.FIGURES if figure not in (x, y, "wall_s")]
    figures = [x, y, *figures]
    rows = [{"length, settings": words(point), "seeds": point["seeds"],
             **{figure: spread(point, figure) for figure in figures}} for point in front.front_of(points, x, y)]
    return markdown.table(["length, settings", "seeds", *figures], rows)


def beside_table(points, x):
    """Each point beside the front of those without its settings, at the same x."""
    def signed(value, places):
        return None if value is None else f"{value:+.{places}f}"

    rows = []
    for point in sorted(points, key=lambda point: (knobs.words_of(point["settings"]), point["length"])):
        gains = front.beside_others(point, points, x)
        rows.append({"settings": knobs.words_of(point["settings"]) or "the default", "length": f"{point['length']:g}",
                     x: spread(point, x), "psnr": spread(point, "psnr"), "gain, dB": signed(gains["psnr"], 2),
                     "gain in SSIM": signed(gains["ssim"], 4), f"{x} of others": gains["times"]})
    return markdown.table(list(rows[0]), rows)


def figure_of(points, by, title):
    """A figure with a panel for each front. Raises ImportError without matplotlib."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(18, 10), layout="constrained")
    figure.suptitle(title)
    kinds = sorted({", ".join(sorted(point["settings"])) for point in points})  # by what was changed; "" is the default
    for axes, (x, y) in zip(figure.subplots(2, 3).flat, panels(by)):
        for number, kind in enumerate(kinds):
            some = [point for point in points if ", ".join(sorted(point["settings"])) == kind]
            several = kind.count(",") > 0
            axes.errorbar([point[x] for point in some], [point[y] for point in some],
                          [point[f"{y}_sd"] or 0 for point in some], [point[f"{x}_sd"] or 0 for point in some],
                          fmt="*" if several else "o" if kind else "s", ms=6, lw=0.8, alpha=0.8,
                          color=f"C{number % 10}" if kind else "k", label=kind or "the default")
        best = front.front_of(points, x, y)
        axes.plot([point[x] for point in best], [point[y] for point in best], "-", color="#888888", lw=1, zorder=1)
        for point in best:
            axes.annotate(words(point), (point[x], point[y]), fontsize=5, xytext=(3, -6), textcoords="offset points",
                          annotation_clip=True)
        axes.set(xscale="log", xlabel=COSTS[x], ylabel=QUALITIES[y])
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        heights = [point[y] for point in points]
        limits = (min(heights), min(heights) + DEPTHS[y]) if y == "cost" else (max(heights) - DEPTHS[y], max(heights))
        axes.set_ylim(limits[0] - 0.05 * DEPTHS[y], limits[1] + 0.05 * DEPTHS[y])
        axes.grid(True, which="both", alpha=0.25)
    figure.axes[0].legend(fontsize=6, loc="lower right")
    return figure


def save(figure, path):
    """As PNG and as SVG beside it, each whole or not at all, the same bytes for the same points."""
    import matplotlib

    matplotlib.rcParams["svg.hashsalt"] = "vesta"
    for form in ("png", "svg"):
        target = path.with_suffix(f".{form}")
        temporary = target.with_name(target.name + ".tmp")
        figure.savefig(temporary, format=form, dpi=120, metadata={"Date": None} if form == "svg" else None)
        os.replace(temporary, target)
