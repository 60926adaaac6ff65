"""Reads a matte with Blender's compositor: cryptomatte.py PICTURE WIDTH HEIGHT LAYER NAME OUTPUT.

The output has a float for each pixel, row by row from the top. Needs: pip install bpy==5.2.3 (Python 3.13).
"""

import pathlib
import sys

import bpy
import numpy

picture, width, height, layer, name, output = sys.argv[1:]
width, height = int(width), int(height)
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
bpy.context.collection.objects.link(scene.camera)

tree = scene.compositing_node_group = bpy.data.node_groups.new("tree", "CompositorNodeTree")
tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
node = tree.nodes.new("CompositorNodeCryptomatteV2")
node.source, node.image = "IMAGE", bpy.data.images.load(picture)
node.layer_name = layer
node.matte_id = name
tree.links.new(node.outputs["Matte"], tree.nodes.new("NodeGroupOutput").inputs[0])

render = scene.render
scene.cycles.samples = 1
render.engine, render.compositor_device = "CYCLES", "CPU"
render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
scene.view_settings.view_transform = "Raw"
render.filepath = str(pathlib.Path(output).with_suffix(".exr"))
bpy.ops.render.render(write_still=True)

matte = numpy.array(bpy.data.images.load(render.filepath).pixels[:], "f").reshape(height, width, 4)
matte[::-1, :, 0].tofile(output)
