"""A ranking as a picture."""


def plot(ranking, axes=None):
    """Draw the harm of every candidate, in the order of the ranking, with matplotlib.

    A bar is the range of the model, a mark the harm itself, or from where to where it may lie if
    work is open; in percent, on a scale of square roots.

    Args:
        ranking: a `Ranking`.
        axes: `matplotlib.axes.Axes` to draw on; None: new ones.

    Returns:
        The axes.
    """
    import numpy
    from matplotlib import pyplot

    rows = ranking.answer["ranking"]
    if axes is None:
        _, axes = pyplot.subplots(figsize=(7, 1.2 + 0.35 * len(rows)), layout="constrained")
    places = numpy.arange(len(rows))
    low, high = 100.0 * numpy.array([row["range"] for row in rows]).reshape(-1, 2).T
    work = 100.0 * numpy.array([row["work"] for row in rows]).reshape(-1, 2)
    axes.set_xscale("function", functions=(
        lambda x: numpy.sqrt(numpy.maximum(x, 0.0)), lambda x: numpy.square(x),
    ))
    axes.barh(places, high - low, left=low, height=0.5, color="0.8", label="range of the model")
    axes.vlines(work[:, 0], places - 0.3, places + 0.3, color="k", label="harm")
    axes.hlines(places, work[:, 0], work[:, 1], color="k")
    axes.vlines(work[:, 1], places - 0.3, places + 0.3, color="k")
    axes.set_yticks(places, [row["name"] for row in rows])
    axes.invert_yaxis()
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f'harm (%), policy "{ranking.policy}"')
    axes.set_title(f"{ranking.scenario}: {ranking.state}")
    axes.legend(loc="upper right")
    return axes
