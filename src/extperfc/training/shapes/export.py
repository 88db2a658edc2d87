"""Writes a trained checkpoint as ONNX with model.yaml and manifest.json beside it."""
import hashlib
import json
import warnings
from pathlib import Path

import cv2
import numpy as np
import torch

from . import HEIGHT, WIDTH, evaluate, network

OPSET = 10  # OpenCV 4.6 rejects some operators of later sets

MODEL_YAML = '''name: shapes
file: shapes.onnx
sha256: {sha256}
input: {{name: images, width: {width}, height: {height}, color: rgb, resize: letterbox, mean: [0, 0, 0], scale: [{scale}, {scale}, {scale}]}}
output: {{layout: yolo_v8, names: [output]}}
classes: [cone, cube, sphere]
thresholds: {{score: {score:.2f}, nms_iou: 0.5}}
source: trained from random weights on rendered images (tools/train_shapes, manifest.json)
license: BSD-3-Clause
'''


def read_weights(path):
    """The averaged weights of a checkpoint, or those of the weights.pt of a model folder."""
    state = torch.load(path, map_location='cpu')
    return {name: value.float() if value.is_floating_point() else value for name, value in state.get('average', state).items()}


def write_onnx(weights, path):
    """Exports a network with these weights and checks OpenCV's answer against PyTorch's; returns the largest difference."""
    net = network.ShapeNet()
    net.load_state_dict(weights)
    whole = network.Exported(net).eval()
    example = torch.rand(1, 3, HEIGHT, WIDTH, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        expected = whole(example).numpy()
    warnings.filterwarnings('ignore', message='.*onnx:Resize.*')  # nearest by a factor of two is the same in every set
    torch.onnx.export(whole, example, str(path), opset_version=OPSET, input_names=['images'], output_names=['output'],
                      do_constant_folding=True)
    loaded = cv2.dnn.readNetFromONNX(str(path))
    loaded.setInput(example.numpy(), 'images')
    difference = float(np.abs(loaded.forward('output') - expected).max())
    if difference > 0.05:
        raise RuntimeError(f'OpenCV and PyTorch differ by {difference} on {path}')
    return difference


def write_weights(weights, path):
    """The weights alone, as half precision numbers: a start for further training."""
    torch.save({name: value.half() if value.is_floating_point() else value for name, value in weights.items()}, path)


def run_notes(recipe, folder):
    """What repeats a run: the recipe, how the images were rendered, and a checksum over them."""
    folder = Path(folder)
    digest = hashlib.sha256()
    images = sorted((folder / 'JPEGImages').glob('*.jpg'))[:recipe['images']]
    for image in images:
        digest.update(image.read_bytes())
    return {'recipe': recipe, 'rendered': (folder / 'render.txt').read_text().splitlines(),
            'images': len(images), 'images_sha256': digest.hexdigest()}


def earlier_runs(weights):
    """The runs that led to the weights of a model folder, by its manifest; none when it has no such file."""
    notes = Path(weights).with_name('manifest.json')
    return json.loads(notes.read_text())['runs'] if notes.exists() else []


def write_manifest(state, path, folder):
    """Writes the run of a checkpoint after those that it continued: {"runs": [...]}."""
    runs = state.get('before', []) + [run_notes(state['recipe'], folder)]
    path.write_text(json.dumps({'runs': runs}, indent=1) + '\n')


def export(trained, model_folder, train_folder, val_folder):
    """Writes shapes.onnx, model.yaml with the threshold of the best F1 on the images of `val_folder`, weights.pt and
    manifest.json. `trained` is a checkpoint, or the weights.pt of the model folder, which then keeps its manifest.
    """
    model_folder = Path(model_folder)
    model_folder.mkdir(parents=True, exist_ok=True)
    path = model_folder / 'shapes.onnx'
    weights = read_weights(trained)
    difference = write_onnx(weights, path)
    (model_folder / 'model.yaml').unlink(missing_ok=True)  # that of an earlier network, perhaps of another size
    table, threshold, _ = evaluate.evaluate(path, val_folder)
    text = MODEL_YAML.format(sha256=hashlib.sha256(path.read_bytes()).hexdigest(), width=WIDTH, height=HEIGHT,
                             scale=repr(1 / 255), score=threshold['score'])
    (model_folder / 'model.yaml').write_text(text)
    state = torch.load(trained, map_location='cpu')
    if 'recipe' in state:
        write_weights(weights, model_folder / 'weights.pt')
        write_manifest(state, model_folder / 'manifest.json', train_folder)
    print(f'{path}: {path.stat().st_size / 1e6:.2f} MB, OpenCV differs from PyTorch by {difference:.1e}, '
          f'val AP50 {table["mean"]["ap50"]:.3f}, score threshold {threshold["score"]:.2f}')
