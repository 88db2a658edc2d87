"""All networks with all three strategies on one target domain: the paper's comparison, by one command.

For each network a source model is trained on the source domain, then the strategies run on the target domain, and every
result is evaluated on its test split. A matrix that was interrupted goes on where it ended.
"""

import concurrent.futures
import contextlib
import dataclasses
import json
import multiprocessing
import multiprocessing.connection
import os
import pathlib
import shutil
import signal
import threading

from . import trainer
from .data import read_dataset
from .errors import TrainingError
from .evaluation import plots
from .evaluation.detector import TorchDetector, detect_all
from .evaluation.report import figure, table_of, write_report
from .experiment import STRATEGIES, make
from .strategies import read_weights
from .text_files import write_text_atomically


@dataclasses.dataclass(frozen=True)
class Plan:
    """What a matrix consists of. training, source_training: keys of experiment.Training."""

    output: pathlib.Path
    target: pathlib.Path
    source: pathlib.Path
    networks: tuple
    strategies: tuple = STRATEGIES
    training: dict = dataclasses.field(default_factory=dict)
    source_training: dict = dataclasses.field(default_factory=dict)
    augmentation: dict = dataclasses.field(default_factory=dict)


def experiment_of(plan, network, strategy):
    """The Experiment of one run; `strategy` "source" is the source model's."""
    is_source = strategy == "source"
    training = plan.source_training if is_source else plan.training
    values = {
        "name": f"{network}, {strategy.replace('_', ' ')}",
        "network": network,
        "strategy": "random_weights" if is_source else strategy,
        "output": str(run_folder(plan, network, strategy)),
        "data": {
            "path": str((plan.source if is_source else plan.target).resolve())
        },
        "training": training,
        "augmentation": plan.augmentation
    }
    if not is_source and strategy != "random_weights":
        values["source"] = str(run_folder(plan, network, "source") / "weights.pt")
    return make(values, plan.output / "matrix.yaml")


def run_folder(plan, network, strategy):
    return (plan.output / network / strategy).resolve()


def run_one(plan, network, strategy, build, report):
    """Trains one run to its end, going on where it was interrupted; returns its history."""
    folder = run_folder(plan, network, strategy)
    done = folder / "done.json"
    if done.exists():
        return json.loads(done.read_text())
    report(f"--- {network}, {strategy.replace('_', ' ')}")
    history = trainer.train(experiment_of(plan, network, strategy), folder.exists(), build, report)
    write_text_atomically(json.dumps(history) + "\n", done)
    shutil.rmtree(folder / "checkpoints")  # twenty models take gigabytes
    return history


def evaluate_one(plan, network, strategy, build, device):
    """The report of one run on the target's test split."""
    folder = run_folder(plan, network, strategy)
    content = read_weights(folder / "weights.pt")
    experiment = experiment_of(plan, network, strategy)
    class_names = tuple(content["class_names"])
    detector = TorchDetector.of_network(build(experiment, class_names), content["weights"], device)
    test = read_dataset(plan.target).with_classes(class_names).split("test")
    detections, truths = detect_all(detector, test)
    return write_report(folder / "test", experiment.name, detections, truths, class_names,
                        lambda index: test.samples[index].read_image())


def run_network(plan, network, build, report):
    """All runs of one network: {(network, strategy): history} and {(network, strategy): report}."""
    device = plan.training.get("device", "auto")
    histories, reports = {}, {}
    if any(strategy != "random_weights" for strategy in plan.strategies):
        run_one(plan, network, "source", build, report)
    for strategy in plan.strategies:
        key = network, strategy
        histories[key] = run_one(plan, network, strategy, build, report)
        reports[key] = evaluate_one(plan, network, strategy, build, device)
        report(f"{network}, {strategy.replace('_', ' ')}: mAP {figure(reports[key]['mean_ap'])} (mean over IoU),"
               f" {figure(reports[key]['mean_ap50'])} (IoU 0.50) on the test images")
    return histories, reports


def end_with_parent(ended):
    """When the process that started this one is gone: SIGTERM, which leaves a checkpoint, and the end."""
    multiprocessing.connection.wait([multiprocessing.parent_process().sentinel])
    os.kill(os.getpid(), signal.SIGTERM)
    ended.wait()
    os._exit(1)  # a worker without its pool waits for work for ever


def run_logged(plan, network, build):
    """run_network in a process of its own; what it prints goes to NETWORK/log.txt."""
    ended = threading.Event()
    threading.Thread(target=end_with_parent, args=[ended], daemon=True).start()
    folder = plan.output / network
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with open(folder / "log.txt", "a", buffering=1) as log, contextlib.redirect_stdout(log), contextlib.redirect_stderr(log):
            return run_network(plan, network, build, print)
    finally:
        ended.set()


def run_side_by_side(plan, build, report, jobs):
    """Yields run_network's results of all networks, `jobs` of them at a time. TrainingError names those that failed."""
    failed = []
    spawn = multiprocessing.get_context("spawn")  # a process per network: its memory of the GPU goes with it
    processes = concurrent.futures.ProcessPoolExecutor(jobs, spawn, max_tasks_per_child=1)
    try:
        running = {processes.submit(run_logged, plan, network, build): network for network in plan.networks}
        report(f"{len(running)} networks, {jobs} at a time; their output is in {plan.output}/NETWORK/log.txt")
        for ended in concurrent.futures.as_completed(running):
            if ended.exception():
                failed.append(f"{running[ended]}: {ended.exception()}")
            else:
                report(f"{running[ended]} is finished")
                yield ended.result()
    finally:
        processes.shutdown(cancel_futures=True)  # after Ctrl-C no further network begins
    if failed:
        raise TrainingError("\n".join(failed))


def run_matrix(plan, build=trainer.build_network, report=print, jobs=1):
    """Runs everything, writes matrix.md, matrix.json and the figures; returns {(network, strategy): report}.

    jobs: networks that are trained at a time, each in a process of its own on the same device.
    """
    plan.output.mkdir(parents=True, exist_ok=True)
    each = (run_side_by_side(plan, build, report, jobs) if jobs > 1 else
            (run_network(plan, network, build, report) for network in plan.networks))
    histories, reports = {}, {}
    for some_histories, some_reports in each:
        histories.update(some_histories)
        reports.update(some_reports)
    order = [(network, strategy) for network in plan.networks for strategy in plan.strategies]
    reports = {key: reports[key] for key in order}
    write_results(plan, histories, reports)
    return reports


def write_results(plan, histories, reports):
    """The table and the two figures of all runs."""
    drawn = {}
    for key, content in reports.items():
        validated = [row for row in histories[key] if "validation_loss" in row]
        drawn[key] = {
            "ap": (content["iou_thresholds"], content["mean_ap_over_iou"], "IoU threshold"),
            "loss": ([r["epoch"] for r in validated], [r["validation_loss"] for r in validated], "epoch")}
    plots.draw_matrix(drawn, "ap", plan.output / "ap_over_iou.png", "mean average precision")
    plots.draw_matrix(drawn, "loss", plan.output / "validation_loss.png", "validation loss", log=True)
    rows = [row_of(key, reports[key], histories[key]) for key in reports]
    write_text_atomically(json.dumps(rows, indent=1) + "\n", plan.output / "matrix.json")
    write_text_atomically(markdown(plan, rows), plan.output / "matrix.md")


def row_of(key, content, history):
    """One run's figures."""
    losses = [row["validation_loss"] for row in history if "validation_loss" in row]
    return {"network": key[0], "strategy": key[1], "mean_ap": content["mean_ap"], "mean_ap50": content["mean_ap50"],
            "mean_ap75": content["mean_ap75"], "coco_ap": (content["coco"] or {}).get("AP"),
            "lowest_validation_loss": min(losses), "epochs": history[-1]["epoch"], "steps": history[-1]["step"]}


def markdown(plan, rows):
    """matrix.md."""
    head = ["network", "strategy", "mAP, mean over IoU 0.01 to 1.00", "mAP at 0.50", "mAP at 0.75", "COCO AP",
            "lowest validation loss", "epochs"]
    body = [[
        r["network"], r["strategy"].replace("_", " "),
        *(figure(r[k])
          for k in ("mean_ap", "mean_ap50", "mean_ap75", "coco_ap", "lowest_validation_loss")), r["epochs"]
    ] for r in rows]
    return "\n\n".join([
        "# Networks and strategies", f"Target: {plan.target.name}, its test split. Source: {plan.source.name}.",
        table_of([head, *body]), "![AP over the IoU threshold](ap_over_iou.png)",
        "![Validation loss over epochs](validation_loss.png)"]) + "\n"
