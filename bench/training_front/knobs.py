"""What trades time, memory or size of a training for quality, as data, and the runs that follow from it.

Options are those of `vesta config`, flat: {"adam.length": 1, ...}. Settings are the few of them that a run changes. A
length is a factor on the iterations that the scene requires.
"""
import json
import math

LENGTH, SEED, SCALE = "adam.length", "train.seed", "train.downscale"


def _values(key, *values, **others):
    """others: what the key has an effect with, ROOM_KEY=VALUE."""
    return [{key: value, **{other.replace("_", ".", 1): given for other, given in others.items()}} for value in values]


# Of each knob the values that are tried beside the default's, which is passed over where it is among them. Whether sums
# are taken in float or double is no option of a training.
KNOBS = {
    "scale": _values(SCALE, 1, 2, 4),
    "coarse": _values("adam.coarse_part", 0, 0.25, 0.75, 0.9),
    "metric": _values("adam.metric", "diagonal"),
    "mean": _values("adam.average_part", 0, 0.25),
    "views": _values("adam.views_per_iteration", 2, 4),
    "rate": _values("adam.rate_factor", 2, 6),
    "decay": _values("adam.rate_decay", 0.2, 1),
    "cooldown": _values("adam.cooldown", 0.2),
    "harmonics' rate": _values("rates.sh_rest", 0.0000625, 0.000375),
    "lm": _values("lm.iterations", 0, 2, 4, 8),
    "pcg": _values("lm.pcg_iterations", 2, 8, 16, lm_iterations=4),
    "preconditioner": _values("lm.preconditioner", "block", "jacobi", lm_iterations=4),
    "jacobian": _values("lm.jacobian", "recompute", "cache16", "cache32", lm_iterations=4),
    "growth": [*_values("density.gradient_threshold", 0.00035, 0.0014, 0.0028), {"density.enabled": False}],
    "gaussians": _values("density.max_gaussians", 5000, 20000, 80000),
    "pruning": _values("parsimony.keep", 0.5, 0.2),
    "sh": _values("train.sh_degree", 0, 1, 2, 3),
}
LENGTHS = (0.0625, 0.125, 0.25, 0.5, 1, 2, 4)


def text_of(value):
    """As --set takes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return ",".join(map(text_of, value)) if isinstance(value, list) else str(value)


def words_of(settings):
    """The settings in one line."""
    return " ".join(f"{key}={text_of(value)}" for key, value in sorted(settings.items()))


def parse_knob(word):
    """A knob's name, or KEY=V1,V2 of one's own, as (name, values). Raises ValueError."""
    if word in KNOBS:
        return word, KNOBS[word]
    key, equals, values = word.partition("=")
    if not equals or "." not in key or not values:
        raise ValueError(f"--knobs {word}: choose from {', '.join(KNOBS)}, or write ROOM.KEY=VALUE,VALUE")

    def value_of(text):
        try:
            return json.loads(text)
        except ValueError:
            return text

    return key, _values(key, *map(value_of, values.split(",")))


def flat(options):
    """{"room": {"key": value}} as {"room.key": value}."""
    return {f"{room}.{key}": value for room, keys in options.items() for key, value in keys.items()}


def changed(base, options):
    """Where the options differ from the base's, but for length and seed."""
    return {key: value for key, value in options.items() if key not in (LENGTH, SEED) and base.get(key) != value}


def that_change(base, chosen):
    """The knobs with what their values change, those that change nothing left out. Raises ValueError for a key that the
    base lacks."""
    for key in sorted({LENGTH, *(key for values in chosen.values() for settings in values for key in settings)}):
        if key not in base:
            raise ValueError(f"the program has no option {key}; `vesta help train --all` lists them")
    return {name: [changed(base, settings) for settings in values if changed(base, settings)]
            for name, values in chosen.items()}


def _each_once(runs):
    seen = set()
    for options in runs:
        name = json.dumps(options, sort_keys=True)
        if name not in seen:
            seen.add(name)
            yield options


def one_at_a_time(base, knobs, lengths, knob_lengths, seeds):
    """The first round, as options of each run: the default at all lengths, its own among them, then each value alone at
    some. All of one seed come before the next, short runs before long ones."""
    runs = []
    lengths = sorted(map(float, {*lengths, base[LENGTH]}))
    for seed in seeds:
        runs += [{**base, LENGTH: length, SEED: seed} for length in lengths]
        alone = [settings for values in knobs.values() for settings in values]
        runs += [{**base, LENGTH: length, **settings, SEED: seed} for length in sorted(map(float, knob_lengths))
                 for settings in alone]
    return list(_each_once(runs))


def combined(base, good, lengths, seeds):
    """The second round: the first two good settings together, the first three, and so on. good: by the length at which
    they were good, a list each; the nearest counts. Of two that contradict each other the second is passed over."""
    runs = []
    for length in sorted(map(float, lengths)):
        merged, count = {}, 0
        for settings in good[min(good, key=lambda other: abs(math.log(other / length)))] if good else []:
            if any(merged.get(key, value) != value for key, value in settings.items()):
                continue
            merged, count = {**merged, **settings}, count + 1
            if count > 1:
                runs += [{**base, **merged, LENGTH: length, SEED: seed} for seed in seeds]
    return sorted(_each_once(runs), key=lambda options: options[SEED])
