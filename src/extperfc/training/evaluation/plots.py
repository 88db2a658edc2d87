"""Figures of an evaluation and of several runs side by side, as the ExtPerFC paper shows them."""

import numpy as np

from ..curves import pyplot

COLUMNS = 5  # networks


def draw_ap_over_iou(evaluation, file, title):
    """AP of every class and their mean over the IoU threshold."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    for name, row in zip(evaluation.class_names, evaluation.ap):
        if not np.isnan(row).all():
            axis.plot(evaluation.thresholds, row, label=f"{name} ({row.mean():.3f})", lw=1)
    mean = evaluation.mean_ap_over_iou()
    axis.plot(evaluation.thresholds, mean, "k", label=f"mean ({evaluation.mean_ap():.3f})", lw=2)
    finish(axis, title, "IoU threshold", "average precision")
    figure.savefig(file, dpi=100)
    plt.close(figure)


def draw_precision_recall(evaluation, file, title, iou=0.5):
    """Precision over recall of every class at one IoU threshold."""
    plt = pyplot()
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    for name, ranking in zip(evaluation.class_names, evaluation.rankings):
        recall, precision, _ = ranking.curve(evaluation.column(iou))
        if ranking.objects:
            ap = ranking.average_precision(evaluation.column(iou))
            axis.step([0, *recall], [1, *precision], where="post", label=f"{name} ({ap:.3f})")
    finish(axis, f"{title}, IoU {iou:.2f}", "recall", "precision")
    figure.savefig(file, dpi=100)
    plt.close(figure)


def finish(axis, title, xlabel, ylabel):
    axis.set(xlabel=xlabel, ylabel=ylabel, xlim=(0, 1), ylim=(0, 1.02), title=title)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, loc="lower left")


def draw_matrix(results, key, file, ylabel, log=False):
    """A panel per network, a line per strategy. results: {(network, strategy): {key: (x, y, xlabel)}}."""
    plt = pyplot()
    networks = list(dict.fromkeys(network for network, _ in results))
    columns = min(COLUMNS, len(networks))
    rows = -(-len(networks) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(3.2 * columns, 3.2 * rows), sharey=True, squeeze=False,
                                constrained_layout=True)
    for axis in axes.flat[len(networks):]:
        axis.set_visible(False)
    for axis, network in zip(axes.flat, networks):
        for (name, strategy), result in results.items():
            if name == network and result[key] is not None:
                x, y, xlabel = result[key]
                axis.plot(x, y, label=strategy.replace("_", " "), marker="o" if len(x) < 12 else None, ms=3)
                axis.set_xlabel(xlabel)
        axis.set_title(network.replace("_", " "), fontsize=9)
        axis.grid(alpha=0.3)
        if log:
            axis.set_yscale("log")
        else:
            axis.set_ylim(0, 1.02)
    for axis in axes[:, 0]:
        axis.set_ylabel(ylabel)
    axes.flat[0].legend(fontsize=7)
    figure.savefig(file, dpi=100)
    plt.close(figure)
