"""says how good a model is: average precision over IoU, COCO's figures, confusions, the worst mistakes

Writes report.md, report.json, ap_over_iou.png, precision_recall.png and mistakes.png.
"""

import pathlib


def add_arguments(parser):
    parser.add_argument("model", type=pathlib.Path, help="output folder of a run, its weights.pt, or a model folder")
    parser.add_argument("data", type=pathlib.Path, help="Pascal VOC folder, COCO file or folder")
    parser.add_argument("--split", default="test", help="images to evaluate on (default: test); all: every image")
    parser.add_argument("--output",
                        type=pathlib.Path,
                        default=pathlib.Path("evaluation"),
                        help="folder (default: evaluation)")
    parser.add_argument("--score",
                        type=float,
                        help="score threshold of the confusion table (default: that of the best F1)")
    parser.add_argument("--backend", choices=("opencv", "openvino"), default="opencv", help="of a model folder")
    parser.add_argument("--device", default="auto", help="of a weights.pt: auto, cpu, cuda or cuda:N")


def run(options):
    from ..data import read_dataset
    from ..evaluation.detector import detect_all, open_detector
    from ..evaluation.report import figure, write_report
    from ..progress import Progress
    dataset = read_dataset(options.data)
    detector = open_detector(options.model, options.backend, options.device)
    dataset = (dataset if options.split == "all" else dataset.split(options.split)).with_classes(detector.class_names)
    detections, truths = detect_all(detector, dataset, Progress(len(dataset)))
    title = f"{options.model.resolve().name} on {options.data.resolve().name}, {options.split}"
    content = write_report(options.output, title, detections, truths, detector.class_names,
                           lambda index: dataset.samples[index].read_image(), options.score)
    print(f"mAP {figure(content['mean_ap'])} (mean over IoU 0.01 to 1.00), {figure(content['mean_ap50'])} (IoU 0.50);"
          f" {options.output / 'report.md'}")
    return 0
