"""Curves of a run, or of several: PNG by Matplotlib, TensorBoard where it is installed."""

import contextlib

LOSS_PARTS = ("classification", "localization", "objectness")


def pyplot():
    """matplotlib.pyplot without a display."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot
    return matplotlib.pyplot


def draw_run(history, file, title):
    """Loss, AP and learning rate over epochs. history: dictionaries as Trainer.history holds them."""
    plt = pyplot()
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), constrained_layout=True)
    epochs = [row["epoch"] for row in history]
    validated = [row for row in history if "validation_loss" in row]
    axes[0].plot(epochs, [row["loss"] for row in history], label="training")
    axes[0].plot(*xy(validated, "validation_loss"), label="validation", marker=marker_of(validated))
    axes[0].set(xlabel="epoch", ylabel="loss", yscale="log" if all(row["loss"] > 0 for row in history) else "linear")
    for key, label in (("ap", "mean over IoU 0.01 to 1.00"), ("ap50", "IoU 0.50"), ("ap75", "IoU 0.75")):
        axes[1].plot(*xy(validated, key), label=label, marker=marker_of(validated))
    axes[1].set(xlabel="epoch", ylabel="validation mAP", ylim=(0, 1))
    axes[2].plot(epochs, [row["learning_rate"] for row in history])
    axes[2].set(xlabel="epoch", ylabel="learning rate at the end")
    for axis in axes:
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize=8)
    axes[1].legend(fontsize=8, loc="lower right")
    figure.suptitle(title)
    figure.savefig(file, dpi=90)
    plt.close(figure)


def xy(rows, key):
    return [row["epoch"] for row in rows], [row[key] for row in rows]


def marker_of(rows):
    """A point alone draws no line."""
    return "o" if len(rows) < 12 else None


class TensorBoard:
    """Scalars for TensorBoard; does nothing where neither tensorboard nor tensorboardX is installed."""

    def __init__(self, folder, first_step):
        self.writer = make_writer(folder, first_step)

    def add(self, row):
        """Every number of a history row, at its step."""
        if self.writer is None:
            return
        for key, value in row.items():
            if key not in ("epoch", "step"):
                self.writer.add_scalar(key, value, row["step"])
        self.writer.flush()

    def close(self):
        if self.writer is not None:
            self.writer.close()


def make_writer(folder, first_step):
    """torch.utils.tensorboard's writer, else tensorboardX's, else None."""
    with contextlib.suppress(ImportError):
        from torch.utils.tensorboard import SummaryWriter
        return SummaryWriter(str(folder), purge_step=first_step)
    with contextlib.suppress(ImportError):
        from tensorboardX import SummaryWriter
        return SummaryWriter(str(folder), purge_step=first_step)
    return None
