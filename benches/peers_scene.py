#!/usr/bin/env python3
"""Turns a scene of ../shared/peers into one of pellucid's, so that both programs draw the same picture.

    peers_scene.py SCENE [--size N] [--early OPACITY] > scene.toml

Same volume, camera, transfer function, step, shading and image size; linear encoding, so that the numbers can be
compared with peers' reference.py. Needs no packages. As a module: `read` and `convert`.
"""
import argparse, json, pathlib

# Beside the checkout, or further up.
SHARED = next((folder / 'shared' for folder in pathlib.Path(__file__).resolve().parents
               if (folder / 'shared' / 'peers').is_dir()), None)
if SHARED is None:
    raise SystemExit('there is no folder shared/peers beside this checkout or above it')
DATA = pathlib.Path('/tmp/peers/data')
TYPES = dict(uint8='u8', uint16='u16', int16='i16', float32='f32')


def read(name):
    """The peers' scene of that name."""
    return json.loads((SHARED / 'peers' / 'scenes' / f'{name}.json').read_text())


def convert(scene, size=512, early=None, data=DATA):
    """The peers' scene as a document of pellucid."""
    volume, shading, camera, mode = (scene[key] for key in ('volume', 'shading', 'camera', 'mode'))
    path = volume['path']
    path = SHARED / 'data' / path[5:] if path.startswith('real/') else pathlib.Path(data).resolve() / path
    lit = 'true' if mode in ('dvr_shaded', 'iso') else 'false'
    lines = ['[[volumes]]']
    if path.suffix == '.raw':
        kind = TYPES[volume['type']]
        lines += [f'source.raw = {{ path = "{path}", dims = {volume["dims"]}, voxel_type = "{kind}" }}']
    else:
        lines += [f'source.file = "{path}"']
    lines += [f'spacing = {volume["spacing"]}', f'shading = {lit}',
              'material = { ' + ', '.join(f'{key} = {shading[key]}' for key in shading) + ' }']
    lines += transfer_function(scene)
    lines += ['[camera]', f'projection.perspective.vertical_fov = {camera["vfov"]}',
              f'view.look_at = {{ position = {camera["position"]}, target = {camera["focal"]}, up = {camera["up"]} }}',
              '[lighting]', 'ambient = 1.0', '[[lighting.lights]]', 'kind.directional.direction = [0, 0, -1]',
              'frame = "camera"', '[quality]', f'step = {scene["step"] / min(volume["spacing"])}',
              f'early_termination = {early if early else scene["early"]}']
    if mode == 'mip':
        lines += ['[technique.ray_cast]', 'mode = "maximum"']
    if mode == 'iso':
        lines += ['[technique.ray_cast.mode.isosurface]', f'isovalues = [{{ value = {scene["iso"]["value"]} }}]']
    lines += ['[image]', f'width = {size}', f'height = {size}', 'encoding = "linear"']
    return '\n'.join(lines) + '\n'


def transfer_function(scene):
    """The lines of the transfer function. A surface has one colour, linear as all of the peers' are: colours of
    isovalues are sRGB-encoded in pellucid, those of a transfer function are in the space it names."""
    if 'iso' in scene:
        value = scene['iso']['value']
        tf = dict(color=[[value, *scene['iso']['color']]], opacity=[[value, 1]], unit_distance=1)
    else:
        tf = scene['tf']
    return ['[volumes.transfer_function]', 'color_space = "linear"',
            f'colors = {json.dumps([[point[0], point[1:]] for point in tf["color"]])}',
            f'opacities = {json.dumps(tf["opacity"])}', f'unit_distance = {float(tf["unit_distance"])}']


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scene')
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--early', type=float, help="opacity at which rays stop [default: the scene's]")
    parser.add_argument('--data', type=pathlib.Path, default=DATA, help='folder of the synthetic volumes')
    arguments = parser.parse_args()
    print(convert(read(arguments.scene), arguments.size, arguments.early, arguments.data), end='')
