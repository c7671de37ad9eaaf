#!/usr/bin/env python3
"""pellucid's GPU backend beside VTK's GPU ray caster on one driver: the same orbit, in turn, with the error of both.

    peers_gpu.py [SCENE...] [--size 512] [--frames 6] [--rounds 3] [--pellucid PATH] [--baseline PATH]
                 [--adapter software] [--args "--interpolation exact"] [--json FILE] [--markdown FILE]

Scenes are those of ../shared/peers and `wavelet256`, the fixture of VTK's own benchmark of its mapper: its wavelet
source with 256^3 voxels, a ramp of opacity, seen as ResetCamera does (run it with --size 900). A frame is camera
change, drawing and the 8-bit picture in memory, in both programs. Times are medians over rounds of each round's
median. The reference is what pellucid's CPU backend draws at the same step with no ray ended early, which peers.py
holds to a brute-force one. With --baseline, another build of pellucid is timed in the same rounds.

Runs with a Python that has numpy, pillow and vtk, and with EGL (Debian: libegl1, libgl1-mesa-dri). Folders as peers.py.
"""
import argparse, json, math, pathlib, shlex, statistics, subprocess, sys, tempfile

import numpy as np
from PIL import Image

import peers, peers_scene

SCENES = ['ct256_dvr', 'ct256_opaque', 'ct256_shaded', 'ct256_mip', 'ct256_iso', 'bonsai_dvr', 'bonsai_shaded',
          'cthead_shaded', 'ml256_dvr', 'ml256_shaded', 'ml256_iso', 'ct512_dvr', 'ct512_mip', 'wavelet256']


def wavelet():
    """VTK's fixture as a scene of the peers, its voxels written if they are not there."""
    file = pathlib.Path(peers.ENV['PEERS_DATA']) / 'wavelet256_f32.raw'
    if not file.exists():
        from vtkmodules.all import vtkRTAnalyticSource
        from vtkmodules.util.numpy_support import vtk_to_numpy
        source = vtkRTAnalyticSource()
        source.SetWholeExtent(-127, 128, -127, 128, -127, 128)
        source.SetCenter(0, 0, 0)
        source.Update()
        vtk_to_numpy(source.GetOutput().GetPointData().GetScalars()).astype('<f4').tofile(file)
    middle, far = 127.5, math.sqrt(3) * 127.5 / math.sin(math.radians(15))
    return dict(name='wavelet256',
                volume=dict(path=file.name, dims=[256] * 3, spacing=[1] * 3, origin=[0] * 3, type='float32'),
                camera=dict(position=[middle, middle, middle + far], focal=[middle] * 3, up=[0, 1, 0], vfov=30),
                orbit=dict(axis=[0, 1, 0], degrees=360, frames=12), image=[900, 900], background=[0, 0, 0],
                mode='dvr', step=1.0, early=0.99, shading=dict(ambient=0.2, diffuse=0.7, specular=0.3, shininess=20),
                tf=dict(color=[[37.3531, 0.2, 0.29, 1], [157.091, 0.87, 0.87, 0.87], [276.829, 0.7, 0.015, 0.15]],
                        opacity=[[37.3531, 0], [276.829, 1]], unit_distance=1))


def read(name):
    return wavelet() if name == 'wavelet256' else peers_scene.read(name)


def time_vtk(scene, file, options):
    told = json.loads(peers.run([sys.executable, peers.PEERS / 'peer_vtk.py', file, '--mapper', 'gpu', '--size',
                                 options.size, '--frames', options.frames]).strip().splitlines()[-1])
    return told['median_ms']


def bench(program, scene, folder, options, flags, early=None):
    """What `pellucid bench` tells of a scene."""
    document = pathlib.Path(folder) / f'{scene["name"]}.toml'
    document.write_text(peers_scene.convert(scene, options.size, early, data=peers.ENV['PEERS_DATA']))
    return json.loads(peers.run([program, 'bench', document, '--allow-outside', '--json', '-', '--quiet', '--orbit',
                                 scene['orbit']['degrees'], *flags]))


def time_pellucid(program, scene, folder, options):
    told = bench(program, scene, folder, options,
                 ['--adapter', options.adapter, '--warmup', 1, '--frames', options.frames, '--picture',
                  peers.picture(scene['name'], options.size, 'pellucid_gpu'), *shlex.split(options.args)])
    timed = told['scenes'][0]
    return timed['orbit']['timing']['median_ms'], timed['renderer'], told['machine']


def reference(scene, folder, options):
    file = peers.picture(scene['name'], options.size, 'pellucid_cpu')
    bench(options.pellucid, scene, folder, options,
          ['--backend', 'cpu', '--frames', 1, '--warmup', 0, '--picture', file], early=1.0)
    return np.asarray(Image.open(file).convert('RGB')).astype(float)


def measure(names, options):
    """A record per scene, all measured in turn; the renderer and the machine."""
    programs = [options.pellucid, *filter(None, [options.baseline])]
    times, records, told = {}, [], None
    with tempfile.TemporaryDirectory() as folder:
        scenes = [read(name) for name in names]
        for turn in range(options.rounds):
            for scene in scenes:
                file = pathlib.Path(folder) / f'{scene["name"]}.json'
                file.write_text(json.dumps(scene))
                row = [time_vtk(scene, file, options)]
                # The build in question last, so that the picture is its own.
                for program in reversed(programs):
                    ms, *told = time_pellucid(program, scene, folder, options)
                    row.insert(1, ms)
                times.setdefault(scene['name'], []).append(row)
                print(f'round {turn + 1} of {options.rounds}: {scene["name"]}: VTK, pellucid: '
                      + ', '.join(f'{ms:.1f} ms' for ms in row), file=sys.stderr, flush=True)
        for scene in scenes:
            name, truth = scene['name'], reference(scene, folder, options)
            vtk, ours, *before = (statistics.median(column) for column in zip(*times[name]))
            errors = [peers.error(peers.picture(name, options.size, what), truth) for what in ('pellucid_gpu', 'vtk_gpu')]
            records.append(dict(scene=name, size=options.size, step=scene['step'], pellucid_ms=ours, vtk_ms=vtk,
                                ratio=vtk / ours, baseline_ratio=before[0] / ours if before else None,
                                rounds_ms=times[name], pellucid_error=errors[0], vtk_error=errors[1]))
    return records, *told


def table(records):
    def said(error):
        return f'{error["psnr"]:.1f} dB, {error["largest"]}' if error['psnr'] else 'equal'
    baseline = any(record['baseline_ratio'] for record in records)
    lines = ['| scene | pellucid ms | VTK ms | VTK / pellucid |' + (' before / after |' if baseline else '')
             + ' pellucid PSNR, largest | VTK PSNR, largest |', '|---|---|---|---|---|---|' + ('---|' if baseline else '')]
    for r in records:
        before = f' {r["baseline_ratio"]:.2f} |' if baseline else ''
        lines.append(f'| {r["scene"]} | {r["pellucid_ms"]:.0f} | {r["vtk_ms"]:.0f} | {r["ratio"]:.2f} |{before} '
                     f'{said(r["pellucid_error"])} | {said(r["vtk_error"])} |')
    ratios = [record['ratio'] for record in records]
    lines += ['', f'VTK / pellucid over {len(ratios)} scenes: geometric mean {statistics.geometric_mean(ratios):.2f}, '
              f'minimum {min(ratios):.2f}.']
    return '\n'.join(lines)


def vtk_driver():
    """Version of VTK and its OpenGL renderer."""
    program = ('import vtkmodules.all as v; w = v.vtkEGLRenderWindow(); w.SetOffScreenRendering(1); w.Render(); '
               'print(v.vtkVersion.GetVTKVersion()); print(w.ReportCapabilities())')
    told = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True).stdout.splitlines()
    lines = [line.strip() for line in told if line.startswith(('OpenGL renderer', 'OpenGL version'))]
    return '; '.join([f'VTK {told[0]}', *lines])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='*', metavar='SCENE', help='default: all, ' + ' '.join(SCENES))
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--frames', type=int, default=6)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--pellucid', type=pathlib.Path, default=peers.ROOT / 'target' / 'release' / 'pellucid')
    parser.add_argument('--baseline', type=pathlib.Path, help='another build of pellucid, timed as well')
    parser.add_argument('--adapter', default='software', help='of pellucid; VTK takes that of EGL')
    parser.add_argument('--args', default='', help='further flags of pellucid bench, in one text')
    parser.add_argument('--json', type=pathlib.Path)
    parser.add_argument('--markdown', type=pathlib.Path)
    options = parser.parse_args()
    unknown = [scene for scene in options.scenes if scene not in SCENES]
    if unknown or options.rounds < 1 or options.frames < 3:
        parser.error(f'unknown scenes {unknown}' if unknown else 'at least 1 round and 3 frames')
    records, renderer, machine = measure(options.scenes or SCENES, options)
    text = table(records)
    print(text)
    how = (f'pellucid {machine["pellucid"]} on {renderer}; {vtk_driver()}; {options.size}x{options.size}, {options.frames} '
           f'frames of an orbit, medians of {options.rounds} rounds in turn, {machine["cpu"]}, {machine["cores"]} cores'
           + (f', `{options.args}`' if options.args else ''))
    if options.json:
        options.json.write_text(json.dumps(dict(how=how, machine=machine, scenes=records), indent=1) + '\n')
    if options.markdown:
        options.markdown.write_text(f'{how}.\n\n{text}\n')


if __name__ == '__main__':
    main()
