#!/usr/bin/env python3
"""pellucid's path tracer beside Mitsuba 3's `volpath` on one sparse cloud: paths per second, and noise at equal paths.

    path_tracer.py [--pellucid PATH] [--size 256] [--samples 16] [--density 40] [--rounds 2] [--variant llvm_ad_rgb | none] [--threads 2]
                   [--folder DIR]

The cloud is made here: 128^3 single precision, extinction linear in the value, so that both programs interpolate the same
medium. One directional light of irradiance pi, a constant sky, Henyey-Greenstein, at most 64 scatterings. Seconds are those
of the processor over all threads, which other programs on the machine disturb less than the clock; Mitsuba's are of its
second picture, when its kernels are compiled. Efficiency is 1 / (variance of a pixel x seconds), from pictures with
different seeds; seconds are the least of them. Local and global majorants are drawn in turns, as often as `--rounds` says.

Runs with a Python that has numpy and mitsuba (pip install numpy mitsuba; the llvm variants also need LLVM's library).
"""
import argparse, json, os, pathlib, resource, subprocess, tempfile, time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
SIDE, G, ALBEDO, SKY, BOUNCES = 128, 0.6, 0.95, 0.3, 64
EYE, TARGET, FOV, TO_SUN = (0.5, -2.2, 0.8), (0.5, 0.5, 0.5), 30.0, (0.6, 0.2, 0.8)

parser = argparse.ArgumentParser()
parser.add_argument('--pellucid', default=ROOT / 'target/release/pellucid')
parser.add_argument('--size', type=int, default=256)
parser.add_argument('--samples', type=int, default=16)
parser.add_argument('--density', type=float, default=40.0, help='optical depth of the box, if it were full')
parser.add_argument('--rounds', type=int, default=2, help='pictures of each kind, at least 2')
parser.add_argument('--variant', default='llvm_ad_rgb', help='of Mitsuba; none leaves it out')
parser.add_argument('--threads', type=int, default=os.cpu_count())
parser.add_argument('--folder', type=pathlib.Path, default=pathlib.Path(tempfile.gettempdir()) / 'pellucid-path-tracer')
args = parser.parse_args()
args.folder.mkdir(parents=True, exist_ok=True)

import mitsuba as mi

mi.set_variant('scalar_rgb' if args.variant == 'none' else args.variant)


def cloud():
    """Some dozen soft balls in a box that is mostly empty."""
    random = np.random.default_rng(7)
    z, y, x = np.mgrid[0:SIDE, 0:SIDE, 0:SIDE] / (SIDE - 1)
    field = np.zeros((SIDE,) * 3)
    for center, radius in zip(random.uniform(0.2, 0.8, (24, 3)), random.uniform(0.03, 0.1, 24)):
        squared = ((x - center[0])**2 + (y - center[1])**2 + (z - center[2])**2) / radius**2
        field = np.maximum(field, np.clip(1 - squared, 0, 1))
    return field.astype('<f4')


def pellucid(samples, seed, majorants='local'):
    """The picture, and processor seconds of drawing."""
    scene = args.folder / 'scene.toml'
    values = np.linspace(0, 1, 257)
    opacities = [[float(v), float(-np.expm1(-args.density * v / (SIDE - 1)))] for v in values]
    spacing = 1 / (SIDE - 1)
    scene.write_text(f'''
[[volumes]]
source.raw = {{ path = "cloud.raw", dims = [{SIDE}, {SIDE}, {SIDE}], voxel_type = "f32" }}
spacing = [{spacing}, {spacing}, {spacing}]
shading = false
[volumes.transfer_function]
colors = [[0, "#ffffff"]]
opacities = {json.dumps(opacities)}
unit_distance = {spacing}
[volumes.scattering]
phase.henyey_greenstein.g = {G}
albedo.constant = {ALBEDO}
[camera]
projection.perspective.vertical_fov = {FOV}
view.look_at = {{ position = {list(EYE)}, target = {list(TARGET)} }}
[lighting]
ambient = 0
[[lighting.lights]]
kind.directional.direction = {[-v for v in TO_SUN]}
[technique.path_trace]
samples = {samples}
seed = {seed}
bounces = {BOUNCES}
roulette = {BOUNCES}
majorants = "{majorants}"
environment.constant = {{ color = "#ffffff", intensity = {SKY} }}
[image]
width = {args.size}
height = {args.size}
''')
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([args.pellucid, 'render', scene, '-o', args.folder / 'pellucid.exr', '--backend', 'cpu', '--threads',
                    str(args.threads), '--quiet'], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    picture = np.array(mi.Bitmap(str(args.folder / 'pellucid.exr')))[..., :3]
    return picture, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def mitsuba_scene(field):
    T = mi.ScalarTransform4f
    half = 0.5 / (SIDE - 1)
    # A grid's samples are at (i + 1/2) / n of its cube, which is half a voxel larger than that of the samples.
    place = T().translate([-half] * 3).scale([1 + 2 * half] * 3)
    extinction = {'type': 'gridvolume', 'grid': mi.VolumeGrid(args.density * field[..., None]), 'to_world': place, 'raw': True}
    medium = {'type': 'heterogeneous', 'sigma_t': extinction, 'albedo': ALBEDO, 'phase': {'type': 'hg', 'g': G}}
    box = T().translate([0.5] * 3).scale([0.5] * 3)
    return mi.load_dict({
        'type': 'scene',
        'integrator': {'type': 'volpath', 'max_depth': BOUNCES + 1, 'rr_depth': BOUNCES + 1, 'hide_emitters': True},
        'sensor': {'type': 'perspective', 'fov': FOV, 'fov_axis': 'y',
                   'to_world': T().look_at(origin=EYE, target=TARGET, up=(0, 0, 1)),
                   'film': {'type': 'hdrfilm', 'width': args.size, 'height': args.size, 'rfilter': {'type': 'box'},
                            'pixel_format': 'rgb'},
                   'sampler': {'type': 'independent', 'sample_count': args.samples}},
        'box': {'type': 'cube', 'to_world': box, 'bsdf': {'type': 'null'}, 'interior': medium},
        'sun': {'type': 'directional', 'direction': [-v for v in TO_SUN],
                'irradiance': {'type': 'rgb', 'value': [float(np.pi)] * 3}},
        'sky': {'type': 'constant', 'radiance': {'type': 'rgb', 'value': [SKY] * 3}},
    })


def mitsuba(scene, seed):
    """The picture, and processor seconds of drawing."""
    before = time.process_time()
    picture = np.array(mi.render(scene, seed=seed))
    return picture, time.process_time() - before


def row(name, pictures):
    """Pictures with their seconds as a line of the table; and their efficiency."""
    seconds = min(seconds for _, seconds in pictures)
    stack = np.array([picture for picture, _ in pictures])
    variance = float(stack.var(axis=0, ddof=1).mean())
    rate = args.size**2 * args.samples / seconds
    efficiency = 1 / (variance * seconds)
    print(f'| {name} | {stack.mean():.5f} | {seconds:.2f} | {rate:.0f} | {variance:.6f} | {efficiency:.1f} |', flush=True)
    return efficiency


field = cloud()
field.tofile(args.folder / 'cloud.raw')
print(f'{(field > 0).mean():.1%} of the voxels are cloud; {args.size}x{args.size}, {args.samples} paths a pixel\n')
print('| program | mean | processor s | paths / processor s | variance | efficiency |')
print('|---|---|---|---|---|---|')
# What starting and loading takes is not drawing.
_, start = pellucid(1, 0)
kinds = ['local', 'global']
drawn = [[pellucid(args.samples, seed, kind) for kind in kinds] for seed in range(1, args.rounds + 1)]
local, whole = [row(f'pellucid, {kind} majorants', pictures) for kind, pictures in zip(kinds, zip(*drawn))]
print(f'\nlocal majorants are {local / whole:.2f} times as efficient as one')
print(f'\n(of pellucid\'s seconds, up to {start:.2f} are starting, loading and one path a pixel)\n')
if args.variant != 'none':
    scene = mitsuba_scene(field)
    mitsuba(scene, 0)
    row(f'Mitsuba {mi.__version__} {args.variant}', [mitsuba(scene, seed) for seed in range(1, args.rounds + 1)])
