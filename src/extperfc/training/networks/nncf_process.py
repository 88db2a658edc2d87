"""Quantizes an ONNX file by NNCF, in a process of its own: python nncf_process.py NETWORK INPUTS OUTPUT.

INPUTS is a .npy file, float32 [K, 3, H, W], of calibration inputs. The process needs nncf, onnx and onnxruntime;
PyTorch is hidden from NNCF, which rejects Debian's version and does not need it for ONNX files.

NNCF writes a pair of QuantizeLinear and DequantizeLinear per tensor. OpenVINO computes only half of a YOLOv7-tiny in
INT8 from these (20.7 ms on one thread), and all of it from its own FakeQuantize (11.1 ms; float 36.3 ms), which it
reads in ONNX too: the pairs are replaced, and only OpenVINO can run the result.
"""

import sys

sys.modules["torch"] = None

import nncf  # noqa: E402
import numpy as np  # noqa: E402
import onnx  # noqa: E402
from onnx import helper, numpy_helper, version_converter  # noqa: E402

OPSET = 13  # the first with a scale per channel
DOMAIN = "org.openvinotoolkit"
LEVELS = 256


def main(network, inputs, output):
    """Writes OUTPUT."""
    model = version_converter.convert_version(onnx.load(network), OPSET)
    samples = np.load(inputs, mmap_mode="r")
    name = model.graph.input[0].name
    dataset = nncf.Dataset([{name: np.array(sample[None])} for sample in samples])
    quantized = nncf.quantize(model, dataset, subset_size=len(samples))
    join_pairs(quantized)
    onnx.save(quantized, output)


def join_pairs(model):
    """Makes one FakeQuantize of every quantized activation: its tensor rounded to 256 levels of its range."""
    graph = model.graph
    constants = {constant.name: constant for constant in graph.initializer}
    pairs = {node.output[0]: node for node in graph.node
             if node.op_type == "QuantizeLinear" and node.input[0] not in constants}
    nodes, renamed = [], {}
    for node in graph.node:
        if node.op_type == "DequantizeLinear" and node.input[0] in pairs:
            first = renamed.setdefault(node.input[0], f"{node.input[0]}_joined")
            renamed[node.output[0]] = first
        elif node.output[0] in pairs:
            nodes.append(fake_quantize(graph, node, constants))
        else:
            nodes.append(node)
    for node in nodes:
        for place, tensor in enumerate(node.input):
            node.input[place] = renamed.get(tensor, tensor)
    del graph.node[:]
    graph.node.extend(nodes)
    model.opset_import.append(helper.make_opsetid(DOMAIN, 1))


def fake_quantize(graph, node, constants):
    """The node that a QuantizeLinear and its DequantizeLinear are together; adds its two limits to the graph: one
    number, or one per channel before depthwise convolutions."""
    scale, zero = (numpy_helper.to_array(constants[name]) for name in node.input[1:3])
    kind = np.iinfo(zero.dtype)
    shape = (1, -1, 1, 1) if scale.size > 1 else (1,)
    limits = []
    for word, level in (("low", kind.min), ("high", kind.max)):
        value = ((level - zero.astype(np.float32)) * scale).astype(np.float32).reshape(shape)
        graph.initializer.append(numpy_helper.from_array(value, f"{node.output[0]}_{word}"))
        limits.append(f"{node.output[0]}_{word}")
    return helper.make_node(
        "FakeQuantize", [node.input[0], *limits, *limits], [f"{node.output[0]}_joined"], domain=DOMAIN, levels=LEVELS
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
