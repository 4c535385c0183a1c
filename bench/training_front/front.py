"""Points of what runs cost and what they reach, the front of those that no other beats, and what lies beside it."""
import json
import math
import statistics

from training_front import knobs, runs


def points_of(rows, base):
    """Runs that differ only in their seed, as one: {"length", "settings": other changes, "seeds": how many,
    and of each figure its mean, and its standard deviation between seeds, None of one alone, as FIGURE_sd}.
    Runs that failed are left out."""
    groups = {}
    for row in rows:
        if "failed" not in row:
            settings = knobs.changed(base, row["options"])
            name = row["options"][knobs.LENGTH], json.dumps(settings, sort_keys=True)
            groups.setdefault(name, []).append(row)
    points = []
    for (length, settings), group in groups.items():
        point = {"length": length, "settings": json.loads(settings), "seeds": len(group)}
        for figure in runs.FIGURES:
            values = [row[figure] for row in group]
            point[figure] = statistics.fmean(values)
            point[f"{figure}_sd"] = statistics.stdev(values) if len(values) > 1 else None
        points.append(point)
    return points


def _height(point, y):
    """y, so that more is better."""
    return -point[y] if y == "cost" else point[y]


def front_of(points, x, y):
    """Those than which no other has a lower x and is at least as good, or is better for at most their x; by x."""
    front = []
    for point in sorted(points, key=lambda point: (point[x], -_height(point, y))):
        if not front or _height(point, y) > _height(front[-1], y):
            front.append(point)
    return front


def _between(front, at, a, b):
    """b where a, which rises along the front, is `at`; a, b: functions of a point."""
    left, right = next(pair for pair in zip(front, front[1:]) if a(pair[0]) <= at <= a(pair[1]))
    return b(left) + (b(right) - b(left)) * (at - a(left)) / (a(right) - a(left))


def best_at(front, x, y, at):
    """The y that the front has for x = at, linear in log x. None where nothing on it is so cheap; beyond its end the
    last one's."""
    if not front or at < front[0][x]:
        return None
    if at >= front[-1][x]:
        return front[-1][y]
    return _between(front, math.log(at), lambda point: math.log(point[x]), lambda point: point[y])


def cost_of(front, x, y, like):
    """The x at which the front is as good as a point, likewise. None where it is not; the first one's x where that is
    better."""
    if not front or _height(like, y) > _height(front[-1], y):
        return None
    if _height(like, y) <= _height(front[0], y):
        return front[0][x]
    at = _height(like, y)
    return math.exp(_between(front, at, lambda point: _height(point, y), lambda point: math.log(point[x])))


def others_of(point, points):
    """The points to compare with: those without its settings, at any length; of a default, all that are none."""
    if not point["settings"]:
        return [other for other in points if other["settings"]]
    settings = point["settings"].items()
    return [other for other in points if not settings <= other["settings"].items()]


def beside_others(point, points, x):
    """What the point gains on the front of the others: "psnr" and "ssim" for the same x; "times": the part of its x
    that they take for its PSNR. None where they have nothing to compare."""
    others = others_of(point, points)
    gains = {}
    for y in ("psnr", "ssim"):
        best = best_at(front_of(others, x, y), x, y, point[x])
        gains[y] = None if best is None else point[y] - best
    same = cost_of(front_of(others, x, "psnr"), x, "psnr", point)
    gains["times"] = None if same is None else same / point[x]
    return gains


def good_settings(points, knobs_values, length, x):
    """Which settings lay on a front of x at this length, and not only because nothing else is so cheap: of each knob
    that which gains most beside the others, the best knob first. knobs_values: of each knob a list of settings."""
    on_front = [point for y in ("psnr", "ssim") for point in front_of(points, x, y)]
    good = []
    for values in knobs_values:
        gains = [(beside_others(point, points, x)["psnr"], knobs.words_of(settings), settings)
                 for settings in values for point in on_front
                 if (point["length"], point["settings"]) == (length, settings)]
        gains = [gain for gain in gains if gain[0] is not None]
        if gains:
            good.append(max(gains, key=lambda gain: gain[:2]))
    return [settings for _, _, settings in sorted(good, key=lambda gain: gain[:2], reverse=True)]
