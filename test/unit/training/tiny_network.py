"""A detector small enough for tests: one box per cell of a 6 x 6 grid on images of 48 x 48 pixels."""

import types

import torch
import torchvision


class TinyNetwork(torch.nn.Module):
    """Keeps the contract of extperfc.training.networks: backbone, head, forward, loss, detect."""

    name, input_size = "tiny", (48, 48)
    learning_rate = 1e-3
    preprocessing = types.SimpleNamespace(color="rgb", resize="stretch", mean=(127.0, 127.0, 127.0), scale=1 / 64)

    def __init__(self, class_names):
        super().__init__()
        self.class_names = tuple(class_names)
        layers, channels = [], 3
        for width in (8, 16, 32):
            layers += [torch.nn.Conv2d(channels, width, 3, 2, 1), torch.nn.BatchNorm2d(width), torch.nn.ReLU()]
            channels = width
        self.backbone = torch.nn.Sequential(*layers)
        self.shared = torch.nn.Sequential(torch.nn.Conv2d(32, 32, 3, 1, 1), torch.nn.Dropout(0.1), torch.nn.ReLU())
        self.boxes = torch.nn.Conv2d(32, 4, 1)
        self.classes = torch.nn.Conv2d(32, len(class_names) + 1, 1)

    def head_parameters(self):
        return [p for part in (self.shared, self.boxes, self.classes) for p in part.parameters()]

    def forward(self, images):
        features = self.shared(self.backbone(images))
        return {
            "boxes": self.boxes(features).flatten(2).transpose(1, 2),
            "logits": self.classes(features).flatten(2).transpose(1, 2)
        }

    def centers(self, device):
        axis = torch.arange(6, device=device) * 8.0 + 4
        y, x = torch.meshgrid(axis, axis, indexing="ij")
        return torch.stack([x.flatten(), y.flatten()], 1)

    def corners(self, raw):
        center, size = raw["boxes"][..., :2] * 8, torch.exp(raw["boxes"][..., 2:].clamp(-4, 4)) * 8
        center = center + self.centers(center.device)
        return torch.cat([center - size, center + size], -1)

    def loss(self, raw, targets):
        corners, kinds = self.corners(raw), torch.zeros(raw["logits"].shape[:2],
                                                        dtype=torch.int64,
                                                        device=raw["logits"].device)
        localization = raw["boxes"].sum() * 0
        for i, target in enumerate(targets):
            boxes, labels = (target[name][~target["ignore"]].to(kinds.device) for name in ("boxes", "labels"))
            for box, label in zip(boxes, labels):
                center = (box[:2] + box[2:]) / 2
                cell = int((self.centers(center.device) - center).abs().sum(1).argmin())
                kinds[i, cell] = label + 1
                localization = localization + torch.nn.functional.smooth_l1_loss(corners[i, cell], box) / 8
        weight = torch.ones(len(self.class_names) + 1, device=kinds.device)
        weight[0] = 0.1
        classification = torch.nn.functional.cross_entropy(raw["logits"].flatten(0, 1), kinds.flatten(), weight)
        return {"classification": classification, "localization": localization / max(1, len(targets))}

    @torch.no_grad()
    def detect(self, raw, score_threshold=0.01, nms_iou=0.45, max_detections=100):
        found = []
        for corners, logits in zip(self.corners(raw), raw["logits"]):
            scores, labels = logits.softmax(-1)[:, 1:].max(-1)
            keep = torchvision.ops.batched_nms(corners, scores, labels, nms_iou)[:max_detections]
            keep = keep[scores[keep] >= score_threshold]
            found.append({"boxes": corners[keep], "scores": scores[keep], "labels": labels[keep]})
        return found


def build(experiment, class_names):
    return TinyNetwork(class_names)
