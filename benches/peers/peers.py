#!/usr/bin/env python3
"""The same loops by Tackscope and by what its peers offer; see README.md beside this file.

Writes one JSON line for each loop, and a table at the end. Seconds are of the processor.
"""
import argparse
import csv
import itertools
import json
import os
import subprocess
import sys
import tempfile
import time

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[threads] = "1"

import numpy as np
from scipy.optimize import minimize

# Amplitude of the noise on flat ground, over the range: without any a uniform field stays uniform.
NOISE = 1e-3


class Case:
    """A loop with the Morse law: its law, its ground, its drive. E* = 1."""

    def __init__(self, name, points, half):
        self.name, self.points, self.half = name, points, half
        if name == "tip":
            # Sect. 4 of the paper, mu_rho = 0.5 (as `scenes::tip`): L = R = 1.
            self.length, self.gamma = 1.0, 0.5859e-3
            self.range = np.sqrt(self.gamma / points)
            self.start, self.turn = 0.012 + 4 * self.range, 0.0
        else:
            # Fig. 2.
            self.length, self.gamma, self.range = 256.0, 0.15, 1.0
            self.start, self.turn = 4.2, 0.2
        self.step = (self.start - self.turn) / half
        self.sigma_max = self.gamma / (2 * self.range)

    def heights(self):
        """The ground, its apex between the points and at zero."""
        x = (np.arange(self.points) + 0.5) / self.points - 0.5
        x, y = np.meshgrid(x, x)
        bend = 0.5 * self.length**2 if self.name == "tip" else 0.0
        return -bend * (x**2 + y**2)

    def drive(self):
        down = self.start - self.step * np.arange(self.half + 1)
        return np.concatenate([down, down[-2::-1]])

    def toml(self):
        ground = 'kind = "hertz"\nradius = 1.0' if self.name == "tip" else 'kind = "flat"'
        return f"""format = 1
[cell]
length = {self.length!r}
points = {self.points}
[law]
kind = "morse"
surface_energy = {self.gamma!r}
range = {float(self.range)!r}
[indenter]
{ground}
[drive]
start = {float(self.start)!r}
turn = {self.turn!r}
step = {float(self.step)!r}
"""


class Numpy:
    """What numpy alone takes for an evaluation: the least that a script costs."""

    transforms = 2

    def __init__(self, case):
        self.case, self.height = case, case.heights()
        q = 2 * np.pi / case.length * np.fft.fftfreq(case.points, 1 / case.points)
        qx = 2 * np.pi / case.length * np.fft.rfftfreq(case.points, 1 / case.points)
        self.stiffness = 0.5 * np.hypot(q[:, None], qx[None, :])

    def evaluate(self, u, u0):
        """Energy per area, and residual traction at every point (a gradient per area)."""
        case = self.case
        elastic = np.fft.irfft2(self.stiffness * np.fft.rfft2(u), s=u.shape)
        a = np.exp(-(u + u0 - self.height) / case.range)
        traction = 2 * case.gamma / case.range * (a - a * a)
        energy = 0.5 * np.mean(u * elastic) + case.gamma * np.mean(a * a - 2 * a)
        return energy, elastic + traction, traction.mean()


class Adhesion:
    """Adhesion: its half-space, its system, a Morse law as one of its potentials."""

    transforms = 2

    def __init__(self, case):
        from Adhesion.Interactions import Potential
        from Adhesion.System.Systems import SmoothContactSystem
        from ContactMechanics import PeriodicFFTElasticHalfSpace
        from SurfaceTopography import Topography

        class Morse(Potential):
            name = "morse"
            r_min, r_infl = 0.0, case.range * np.log(2)

            def __init__(self):
                super().__init__()

            def __repr__(self):
                return "Morse"

            def evaluate(self, gap, potential=True, gradient=False, curvature=False, mask=None):
                a = np.exp(-gap / case.range)
                energy = case.gamma * (a * a - 2 * a) if potential else None
                slope = 2 * case.gamma / case.range * (a - a * a) if gradient else None
                return energy, slope, None

        shape, sides = (case.points,) * 2, (case.length,) * 2
        self.case = case
        self.system = SmoothContactSystem(
            PeriodicFFTElasticHalfSpace(shape, 1.0, sides),
            Morse(),
            Topography(case.heights(), physical_sizes=sides, periodic=True),
        )

    def evaluate(self, u, u0):
        energy, force = self.system.evaluate(u, -u0, pot=True, forces=True)
        area = self.case.length**2
        point = area / u.size
        traction = -self.system.interaction_force / point
        return energy / area, -force / point, traction.mean()


class Tamaas:
    """Tamaas: its operator of the half-space; its solvers hold a hard wall, and know no law whose
    repulsion is smooth."""

    transforms = 2

    def __init__(self, case):
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        sides, shape = [case.length] * 2, [case.points] * 2
        self.case, self.height = case, case.heights()
        self.model = tamaas.Model(tamaas.model_type.basic_2d, sides, shape)
        self.model.E, self.model.nu = 1.0, 0.0
        self.traction = np.zeros(shape)

    def evaluate(self, u, u0):
        case, model = self.case, self.model
        model.displacement[:] = u
        model.solveDirichlet()
        elastic = np.array(model.traction)
        elastic -= elastic.mean()
        a = np.exp(-(u + u0 - self.height) / case.range)
        traction = 2 * case.gamma / case.range * (a - a * a)
        energy = 0.5 * np.mean(u * elastic) + case.gamma * np.mean(a * a - 2 * a)
        return energy, elastic + traction, traction.mean()


def by_minimiser(peer, case, tolerance):
    """The loop by SciPy's L-BFGS-B, which Adhesion calls too, from the state before."""
    shape = (case.points,) * 2
    rng = np.random.default_rng(1)
    u, evaluations, worst, stresses = np.zeros(shape), 0, 0.0, []
    # In units in which stiffness and gap are near 1.
    unit = case.range
    began = time.process_time()
    for u0 in case.drive():
        last = {}

        def objective(x):
            field = unit * x.reshape(shape)
            field = field - field.mean()
            energy, residual, stress = peer.evaluate(field, u0)
            residual = residual - residual.mean()
            last.update(residual=abs(residual).max() / case.sigma_max, stress=stress)
            scale = case.points**2 / (case.sigma_max * unit)
            return energy * scale, residual.ravel() * unit * scale / case.points**2

        if case.name == "flat":
            u = u + NOISE * case.range * rng.standard_normal(shape)
        options = dict(maxiter=20_000, maxfun=40_000, maxcor=10, ftol=0, gtol=tolerance)
        found = minimize(objective, (u / unit).ravel(), jac=True, method="L-BFGS-B", options=options)
        u = unit * found.x.reshape(shape)
        u -= u.mean()
        evaluations += found.nfev
        objective(found.x)
        worst = max(worst, last["residual"])
        stresses.append(last["stress"])
    seconds = time.process_time() - began
    loss = np.trapezoid(stresses, case.drive()) / case.gamma
    increments = len(stresses)
    return dict(
        increments=increments,
        seconds=seconds,
        seconds_per_increment=seconds / increments,
        transforms_per_increment=peer.transforms * evaluations / increments,
        residual=worst,
        loss=loss,
        stability="not known",
    )


def by_tackscope(program, case):
    """The loop as `tackscope run` plans it, all its states in equilibrium and proved stable."""
    with tempfile.TemporaryDirectory() as home:
        scene, out = f"{home}/scene.toml", f"{home}/out"
        with open(scene, "w") as file:
            file.write(case.toml())
        subprocess.run([program, "run", scene, "--out", out, "--quiet"], check=True)
        with open(f"{out}/summary.json") as file:
            told = json.load(file)
        with open(f"{out}/loop.csv") as file:
            increments = sum(1 for _ in file) - 1
    seconds = told["processor_seconds"]
    return dict(
        increments=increments,
        seconds=seconds,
        seconds_per_increment=seconds / increments,
        transforms_per_increment=told["counts"]["transforms"] / increments,
        residual=told["residual_max"],
        loss=told["dissipated_energy"],
        stability="of every state",
    )


def by_reading_off(program, case):
    """The same loop read off the branches of an atlas, as the window shows it: the loss alone, to four digits and more."""
    with tempfile.TemporaryDirectory() as home:
        scene, out = f"{home}/scene.toml", f"{home}/out"
        with open(scene, "w") as file:
            file.write(case.toml())
        subprocess.run([program, "chart", scene, "--quick", "--out", out, "--quiet"], check=True)
        with open(f"{out}/chart.csv") as file:
            told = next(row for row in csv.DictReader(file) if row["model"] == "atlas")
    seconds, states = float(told["processor_seconds"]), float(told["transforms"]) / float(told["transforms_per_increment"])
    return dict(
        increments=round(states),
        seconds=seconds,
        seconds_per_increment=seconds / states,
        transforms_per_increment=float(told["transforms_per_increment"]),
        residual=float("nan"),
        loss=float(told["dissipated_energy"]),
        stability="of every branch",
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tackscope", default="target/release/tackscope")
    parser.add_argument("--points", type=int, nargs="+", default=[64, 128])
    parser.add_argument(
        "--increments", type=int, nargs="+", default=[35], help="increments from the start down to the turn"
    )
    parser.add_argument("--cases", nargs="+", default=["tip", "flat"], choices=["tip", "flat"])
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-4,
        help="largest residual over sigma_max that ends a minimisation; Tackscope's is 1e-6",
    )
    parser.add_argument("--peers", nargs="+", default=["numpy", "adhesion", "tamaas"])
    arguments = parser.parse_args()
    rows = []
    for name in arguments.cases:
        for points, half in itertools.product(arguments.points, arguments.increments):
            case = Case(name, points, half)
            runs = {"tackscope": lambda: by_tackscope(arguments.tackscope, case)}
            if name == "flat":
                runs["tackscope, read off"] = lambda: by_reading_off(arguments.tackscope, case)
            for peer, made in (("numpy", Numpy), ("adhesion", Adhesion), ("tamaas", Tamaas)):
                if peer in arguments.peers:
                    runs[peer] = lambda made=made: by_minimiser(
                        made(case), case, arguments.tolerance
                    )
            for who, run in runs.items():
                try:
                    told = run()
                except ImportError as missing:
                    print(f"skipped {who}: {missing}", file=sys.stderr)
                    continue
                rows.append(dict(case=name, points=points, half=half, by=who, **told))
                print(json.dumps(rows[-1]), flush=True)
    key = lambda row: (row["case"], row["points"], row["half"])
    own = {key(row): row for row in rows if row["by"] == "tackscope"}
    head = "case n increments by | s/loop | times Tackscope | transforms/increment | residual | loss/gamma | stability"
    print(head, file=sys.stderr)
    for row in rows:
        ratio = row["seconds"] / own[key(row)]["seconds"]
        print(
            f"{row['case']} {row['points']} {row['increments']} {row['by']} | {row['seconds']:.3g} | {ratio:.3g} | "
            f"{row['transforms_per_increment']:.0f} | {row['residual']} | {row['loss']:.5f} | "
            f"{row['stability']}",
            file=sys.stderr,
        )


if __name__ == "__main__":
    main()
