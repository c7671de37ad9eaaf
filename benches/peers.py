#!/usr/bin/env python3
"""pellucid beside VTK on the scenes of ../shared/peers: the same orbit, in turn, with the error of both pictures.

    peers.py [SCENE...] [--size 512] [--frames 6] [--rounds 3] [--pellucid PATH] [--args "--threads 1"]
             [--json FILE] [--markdown FILE]

A frame is camera change, drawing and the 8-bit picture in memory, in both programs. Times are medians over rounds of
each round's median. Errors are those of frame 0, 8 bits, against the brute-force reference, which is made once. VTK's
ray caster has no isosurfaces: those stand beside its shaded picture of the same volume.

Runs with a Python that has numpy, pillow and vtk. Folders: PEERS_DATA (synthetic volumes), PEERS_IMG (pictures and
references), PEERS_RESULTS (VTK's log), by default in /tmp/peers.
"""
import argparse, json, math, os, pathlib, resource, shlex, statistics, subprocess, sys, tempfile, time

import numpy as np
from PIL import Image

import peers_scene

GROUPS = {
    'unshaded': ['ct256_dvr', 'ct256_opaque', 'bonsai_dvr', 'ml256_dvr', 'ct512_dvr', 'ct512_opaque'],
    'shaded': ['ct256_shaded', 'bonsai_shaded', 'cthead_shaded', 'ml256_shaded', 'ct512_shaded'],
    'mip': ['ct256_mip', 'ct512_mip'],
    'iso': ['ct256_iso', 'ml256_iso', 'ct512_iso'],
}
ROOT = pathlib.Path(__file__).resolve().parents[1]
PEERS = peers_scene.SHARED / 'peers'
WORK = pathlib.Path('/tmp/peers')
ENV = {'PEERS_DATA': str(peers_scene.DATA), 'PEERS_IMG': str(WORK / 'img'), 'PEERS_RESULTS': str(WORK / 'results.jsonl'),
       'PYTHONDONTWRITEBYTECODE': '1', **os.environ, 'PEERS_REAL': str(peers_scene.SHARED / 'data')}
IMG = pathlib.Path(ENV['PEERS_IMG'])


def run(command):
    """Standard output of a program that must succeed."""
    done = subprocess.run([str(part) for part in command], env=ENV, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f'{shlex.join(str(part) for part in command)}\nfailed with {done.returncode}:\n{done.stderr}')
    return done.stdout


def vtk_name(scene):
    """The scene VTK draws beside one of pellucid's."""
    return scene.replace('_iso', '_shaded')


def time_vtk(scene, options):
    line = run([sys.executable, PEERS / 'peer_vtk.py', scene, '--mapper', 'cpu', '--size', options.size,
                '--frames', options.frames]).strip().splitlines()[-1]
    told = json.loads(line)
    return told['median_ms'], told['cores_used']


def child_seconds():
    """Processor time of all programs run so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def time_pellucid(scene, options, folder):
    document = pathlib.Path(folder) / f'{scene}.toml'
    document.write_text(peers_scene.convert(peers_scene.read(scene), options.size, data=ENV['PEERS_DATA']))
    started, before = time.perf_counter(), child_seconds()
    told = json.loads(run([options.pellucid, 'bench', document, '--allow-outside', '--frames', options.frames,
                           '--json', '-', '--quiet', '--orbit', peers_scene.read(scene)['orbit']['degrees'],
                           '--picture', picture(scene, options.size, 'pellucid'), *shlex.split(options.args)]))
    # Of the whole process: reading the volume counts as well.
    used = (child_seconds() - before) / (time.perf_counter() - started)
    timing = told['scenes'][0]['orbit']['timing']
    return timing['median_ms'], used, timing['threads'], told['machine']


def picture(scene, size, what):
    return IMG / f'{scene}_{size}_{what}.png'


def reference(scene, size):
    """Frame 0 as defined, 8-bit RGB, made if it is not there."""
    file = IMG / f'{scene}_{size}_reference.npy'
    if not file.exists():
        print(f'making the reference of {scene} at {size}x{size} ...', file=sys.stderr, flush=True)
        run([sys.executable, PEERS / 'reference.py', scene, '--size', size])
    rgba = np.load(file).astype(float)
    rgb = rgba[..., :3] + (1 - rgba[..., 3:]) * np.array(peers_scene.read(scene)['background'])
    return np.rint(np.clip(rgb, 0, 1) * 255)


def error(file, truth):
    """PSNR in dB (None if equal) and the largest difference of 255."""
    difference = np.abs(np.asarray(Image.open(file).convert('RGB')).astype(float) - truth)
    square = (difference ** 2).mean()
    return dict(psnr=10 * math.log10(255 ** 2 / square) if square else None, largest=int(difference.max()))


def measure(scenes, options):
    """A record per scene, all measured in turn, and the machine."""
    ours, theirs, machine = {}, {}, None
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(options.rounds):
            for scene in scenes:
                # A scene and its isosurface stand beside the same frames of VTK.
                vtk = theirs.setdefault(vtk_name(scene), [])
                if len(vtk) == turn:
                    vtk.append(time_vtk(vtk_name(scene), options))
                *timed, machine = time_pellucid(scene, options, folder)
                ours.setdefault(scene, []).append(timed)
                print(f'round {turn + 1} of {options.rounds}: {scene}: {timed[0]:.1f} ms, VTK {vtk[turn][0]:.1f} ms',
                      file=sys.stderr, flush=True)
    return [record(scene, ours[scene], theirs[vtk_name(scene)], options) for scene in scenes], machine


def record(scene, ours, theirs, options):
    truth = reference(scene, options.size)
    ms, used, threads = zip(*ours)
    vtk_ms, vtk_used = zip(*theirs)
    same = vtk_name(scene) == scene
    return dict(scene=scene, pellucid_ms=statistics.median(ms), vtk_ms=statistics.median(vtk_ms),
                ratio=statistics.median(vtk_ms) / statistics.median(ms), rounds_ms=ms, vtk_rounds_ms=vtk_ms,
                threads=threads[0], cores_used=statistics.median(used), vtk_cores_used=statistics.median(vtk_used),
                pellucid_error=error(picture(scene, options.size, 'pellucid'), truth),
                vtk_error=error(picture(scene, options.size, 'vtk_cpu'), truth) if same else None)


def summary(records):
    """Geometric mean and minimum of the ratios of every group, over the scenes measured."""
    groups = {}
    for name, scenes in GROUPS.items():
        ratios = [record['ratio'] for record in records if record['scene'] in scenes]
        if ratios:
            groups[name] = dict(scenes=len(ratios), of=len(scenes), geometric_mean=statistics.geometric_mean(ratios),
                                minimum=min(ratios))
    return groups


def warnings(records, machine):
    """A program that had not all its cores was not measured fairly: something else ran, or it cannot use them."""
    told = {}
    for record in records:
        pairs = [('pellucid', record['scene'], record['cores_used'], record['threads'], 0.7),
                 ('VTK', vtk_name(record['scene']), record['vtk_cores_used'], machine['cores'], 0.9)]
        for program, scene, used, cores, least in pairs:
            if used < least * cores:
                told[program, scene] = f'{program} used {used:.2f} of {cores} cores on {scene}'
    return list(told.values())


def tables(records, groups):
    """Both tables in Markdown."""
    def said(error):
        if error is None:
            return '-'
        return f'{error["psnr"]:.1f} dB, {error["largest"]}' if error['psnr'] else 'equal'
    lines = ['| scene | pellucid ms | VTK ms | VTK / pellucid | pellucid PSNR, largest | VTK PSNR, largest |',
             '|---|---|---|---|---|---|']
    lines += [f'| {r["scene"]} | {r["pellucid_ms"]:.1f} | {r["vtk_ms"]:.1f} | {r["ratio"]:.2f} | '
              f'{said(r["pellucid_error"])} | {said(r["vtk_error"])} |' for r in records]
    lines += ['', '| VTK / pellucid | scenes | geometric mean | minimum |', '|---|---|---|---|']
    lines += [f'| {name} | {g["scenes"]} of {g["of"]} | {g["geometric_mean"]:.2f} | {g["minimum"]:.2f} |'
              for name, g in groups.items()]
    return '\n'.join(lines)


def main():
    known = [scene for scenes in GROUPS.values() for scene in scenes]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenes', nargs='*', metavar='SCENE', help='default: all, ' + ' '.join(known))
    parser.add_argument('--size', type=int, default=512)
    parser.add_argument('--frames', type=int, default=6)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--pellucid', type=pathlib.Path, default=ROOT / 'target' / 'release' / 'pellucid')
    parser.add_argument('--args', default='', help='further flags of pellucid bench, in one text')
    parser.add_argument('--json', type=pathlib.Path)
    parser.add_argument('--markdown', type=pathlib.Path)
    options = parser.parse_args()
    unknown = [scene for scene in options.scenes if scene not in known]
    if unknown or options.rounds < 1 or options.frames < 3:
        parser.error(f'unknown scenes {unknown}' if unknown else 'at least 1 round and 3 frames')
    records, machine = measure(options.scenes or known, options)
    groups, remarks = summary(records), warnings(records, machine)
    text = tables(records, groups)
    print(text)
    for remark in remarks:
        print(f'warning: {remark}')
    how = (f'pellucid {machine["pellucid"]} and VTK\'s CPU ray caster, {options.size}x{options.size}, {options.frames} frames '
           f'of an orbit, medians of {options.rounds} rounds in turn, {machine["cpu"]}, {machine["cores"]} cores'
           + (f', `{options.args}`' if options.args else ''))
    if options.json:
        options.json.write_text(json.dumps(dict(how=how, machine=machine, args=options.args, scenes=records, groups=groups,
                                                warnings=remarks), indent=1) + '\n')
    if options.markdown:
        options.markdown.write_text(f'{how}.\n\n{text}\n' + ''.join(f'\n{remark}.\n' for remark in remarks))


if __name__ == '__main__':
    main()
