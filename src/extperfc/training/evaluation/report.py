"""The report of an evaluation: report.md, report.json, figures, and the worst mistakes in images."""

import json
import pathlib

import cv2
import numpy as np

from ..text_files import write_text_atomically
from . import coco, plots
from .average_precision import evaluate
from .confusion import confusion, contact_sheet, worst

SHEET_CELLS = 20


def write_report(folder, title, detections, truths, class_names, read_image, score=None):
    """Evaluates Detections against Truths, writes everything into `folder`; returns the content of report.json.

    read_image(index) gives image uint8 [H, W, 3] RGB. score: threshold of the confusion table; None: that of the best
    F1.
    """
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    evaluation = evaluate(detections, truths, class_names)
    content = {"title": title, **evaluation.as_dict()}
    content["coco"] = coco.coco_metrics(detections, truths, class_names) if coco.is_available() else None
    score = content["best_threshold"]["score"] if score is None else score
    table, mistakes = confusion(detections, truths, class_names, score)
    content["confusion"] = {"score": score, "iou": 0.5, "rows": [*class_names, "no object"],
                            "columns": [*class_names, "missed"], "table": table.tolist()}
    content["mistakes"] = len(mistakes)
    plots.draw_ap_over_iou(evaluation, folder / "ap_over_iou.png", title)
    plots.draw_precision_recall(evaluation, folder / "precision_recall.png", title)
    sheet = contact_sheet(worst(mistakes, SHEET_CELLS), read_image, truths)
    cv2.imwrite(str(folder / "mistakes.png"), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    write_text_atomically(json.dumps(without_nan(content), indent=1) + "\n", folder / "report.json")
    write_text_atomically(markdown(content), folder / "report.md")
    return content


def without_nan(value):
    """JSON has no NaN; null stands for it."""
    if isinstance(value, dict):
        return {k: without_nan(v) for k, v in value.items()}
    if isinstance(value, list):
        return [without_nan(v) for v in value]
    return None if isinstance(value, float) and np.isnan(value) else value


def figure(value):
    """Three digits; a dash where there is nothing to measure."""
    return "-" if value is None or np.isnan(value) else f"{value:.3f}"


def table_of(rows):
    """Markdown of rows, the first one being the head."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def markdown(content):
    """report.md: the tables, and the figures by name."""
    classes = [["class", "objects", "AP, mean over IoU 0.01 to 1.00", "AP at IoU 0.50", "AP at IoU 0.75"]]
    classes += [[name, c["objects"], figure(c["ap"]), figure(c["ap50"]), figure(c["ap75"])]
                for name, c in content["classes"].items()]
    classes.append(["**mean**", sum(c["objects"] for c in content["classes"].values()), figure(content["mean_ap"]),
                    figure(content["mean_ap50"]), figure(content["mean_ap75"])])
    best, confused = content["best_threshold"], content["confusion"]
    cells = [["object \\ detection", *confused["columns"]]]
    cells += [[name, *row] for name, row in zip(confused["rows"], confused["table"])]
    return "\n\n".join([
        f"# {content['title']}", f"{content['images']} images.", "## Average precision",
        table_of(classes), "![AP over the IoU threshold](ap_over_iou.png)",
        "![Precision over recall](precision_recall.png)",
        f"The score threshold {best['score']:.2f} has the best F1, {best['f1']:.3f}: precision {best['precision']:.3f},"
        f" recall {best['recall']:.3f} at IoU 0.50.", "## COCO",
        coco_section(content["coco"]), f"## Confusions at score {confused['score']:.2f}, IoU 0.50",
        table_of(cells),
        f"{content['mistakes']} mistakes; the worst of each kind, labelled objects in green, the detection in red:",
        "![The worst mistakes](mistakes.png)"
    ]) + "\n"


def coco_section(figures):
    if figures is None:
        return f"Not computed: {coco.HINT}."
    return table_of([["figure", "value"], *([name, figure(value)] for name, value in figures.items())])
