"""The homogeneous loop by GetFEM, on the axes of the study of cost: its augmented Lagrangian with a coupled Coulomb
projection.

The same problem on a graded mesh of the same kind: P2 displacements, P1 multipliers, and a P1 mean stress where the
mixed form pays; the cylinder is a rigid obstacle with the flat surface's normal, moved by the two line loads; the far
field is prescribed as in this package. GetFEM is not needed for anything else.
"""

import time

import getfem
import numpy as np

from analytic import point_force_displacement
from forms.depth_map import DepthMap

from ...fem.mesh import Grading, columns, layers
from ...loading.schedule import rocking
from ...runs.comparison import relative_l2
from ...runs.coupled_loop import loop_of
from ...scene import parse
from ...scene.scaling import Scaled
from .cases import GETFEM, Case

CONTACT, FAR = 1, 2
QUARTER = 10  # increments up; forty for the cycle
TOLERANCE = 1e-10  # of the residual at P = 1; 1e-6 is a fifth faster and enough on the two coarse meshes only
MOVE = "[1,0;0,0]*(u-d-s0)"  # slip of the load step


def measure(case: Case) -> dict:
    """Seconds, sizes and errors of the loop by GetFEM on one mesh; ``failure`` where there is no answer."""
    t = float(case.level)
    scene = parse(case.text, (f"solver.increments={QUARTER}",))
    scaled = Scaled.of(scene)
    edge = 1.25e-3 * t**2
    edges = -scaled.contact.a, -0.317, 0.317, scaled.contact.a
    layer_growth, extent, is_mixed = GETFEM[t]
    grading = Grading(edges, 0.025 * t, edge, 1.6, edge, layer_growth, extent)
    schedule = rocking(1.0, 0.9 * scene.mu, 1, QUARTER)
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        unknowns, states = _loop(scene, scaled, grading, is_mixed, schedule)
        row = {"unknowns": unknowns, "surface_nodes": len(states[0]["x"]), "increments": len(states)}
        row |= {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
        return row | _errors(scene, scaled, schedule, states)
    except RuntimeError as error:
        return {"failure": str(error).splitlines()[0][:200]}


def _loop(scene, scaled, grading, is_mixed, schedule):
    """Number of unknowns, and after each load step x, weight, p, q and slip at the contact's P2 nodes."""
    getfem.util("trace level", 0)
    getfem.util("warning level", 0)
    x, y = columns(grading), -layers(grading, DepthMap())[::-1]
    mesh = getfem.Mesh("cartesian", x, y)
    surface = mesh.outer_faces_with_direction([0.0, 1.0], 0.01)
    mesh.set_region(CONTACT, _under(mesh, surface, grading.strip))
    mesh.set_region(FAR, _without(mesh.outer_faces(), surface))
    u, multipliers = getfem.MeshFem(mesh, 2), getfem.MeshFem(mesh, 2)
    u.set_fem(getfem.Fem("FEM_QK(2,2)"))
    multipliers.set_fem(getfem.Fem("FEM_QK(2,1)"))
    integration = getfem.MeshIm(mesh, getfem.Integ("IM_GAUSS_PARALLELEPIPED(2,5)"))
    model = getfem.Model("real")
    nu = scene.solid.nu
    E = float(scaled.modulus.young(1.0))
    model.add_fem_variable("u", u)
    model.add_filtered_fem_variable("l", multipliers, CONTACT)
    model.add_variable("d", 2)
    model.set_variable("d", [0.0, -float(scaled.indenter.height(1.0))])
    lame, shear = nu * E / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    data = {"la": lame, "mu": shear, "f": 0.0, "r": 10.0 * E, "P": 1.0, "Q": 0.0, "pin": 1.0}
    for name, value in data.items():
        model.add_initialized_data(name, [value])
    curvature = 2.0 * float(scaled.indenter.height(1.0))
    model.add_initialized_data("A", [curvature])
    model.add_initialized_fem_data("s0", u, np.zeros(u.nbdof()))
    elasticity = "(la*Trace(Grad_u)*Id(2)+2*mu*Sym(Grad_u)):Grad_Test_u"
    if is_mixed:
        mean_stress = getfem.MeshFem(mesh, 1)
        mean_stress.set_fem(getfem.Fem("FEM_QK(2,1)"))
        model.add_fem_variable("m", mean_stress)
        elasticity = "2*mu*Sym(Grad_u):Grad_Test_u+m*Trace(Grad_Test_u)+(Trace(Grad_u)-m/la)*Test_m"
    model.add_linear_term(integration, elasticity)
    model.add_initialized_fem_data("far", u, np.zeros(u.nbdof()))
    model.add_Dirichlet_condition_with_simplification("u", FAR, "far")
    gap = "(A*X(1)*X(1)/2+d(2)-u(2))"
    projection = f"Coulomb_friction_coupled_projection(l,[0;1],{MOVE},{gap},f,r)"
    model.add_nonlinear_term(integration, "-l.Test_u", CONTACT)
    model.add_nonlinear_term(integration, "l.Test_d", CONTACT)
    under = np.unique(mesh.pts(mesh.pid_in_faces(mesh.region(CONTACT)))[0])
    length = float(under[-1] - under[0])
    model.add_nonlinear_term(integration, f"(P*Test_d(2)+(pin*d(1)-Q)*Test_d(1))/{length!r}", CONTACT)
    model.add_nonlinear_term(integration, f"(1/r)*(l-{projection}).Test_l", CONTACT)
    nodes = u.basic_dof_nodes()[:, ::2]
    place = nodes[0], np.maximum(-nodes[1], 0.0)  # x and depth

    def solve(P, Q):
        model.set_variable("P", [P])
        model.set_variable("Q", [Q])
        displacement = point_force_displacement(scaled.solid, *place, fixed_depth=grading.extent, P=P, Q=Q)
        displacement[1] *= -1.0  # up here, into the body there
        model.set_variable("far", displacement.T.ravel())
        _, converged = model.solve(
            "max_res", TOLERANCE, "max_iter", 60, "lsolver", "mumps", "lsearch", "simplest", "alpha min", 0.2
        )
        if not converged:
            raise RuntimeError(f"not converged at P = {P:g}, Q = {Q:g}")

    states = _states(model, mesh, u, schedule, solve, scene.mu)
    return model.nbdof(), states


def _states(model, mesh, u, schedule, solve, mu):
    on_top = u.basic_dof_on_region(CONTACT)[::2]
    x = u.basic_dof_nodes()[0, on_top]
    order = np.argsort(x)
    x, on_top = x[order], on_top[order]
    length = np.diff(x[::2])
    weight = np.zeros_like(x)  # Simpson's rule, cell by cell
    weight[:-1:2] += length / 6
    weight[2::2] += length / 6
    weight[1::2] = length * 4 / 6

    def relative():
        values = model.variable("u").copy()
        values[::2] -= model.variable("d")[0]
        return values

    def state():
        force = model.interpolation("l", np.vstack([x, np.full_like(x, -1e-12)]), mesh).reshape(-1, 2)
        return {"x": x, "weight": weight, "p": -force[:, 1], "q": force[:, 0]}

    solve(1.0, 0.0)
    rest, states = relative()[on_top], []
    model.set_variable("f", [mu])
    model.set_variable("pin", [0.0])  # without friction nothing else holds the cylinder
    for step in schedule:
        begin = relative()
        begin[1::2] = 0.0  # only x components: the positions at which the load step begins
        model.set_variable("s0", begin)
        solve(step.P, step.Q)
        states.append(state() | {"slip": relative()[on_top] - rest})
    return states


def _errors(scene, scaled, schedule, states):
    """Against the half-plane solver without load steps, at the last state, the worst one, and over the cycle."""
    exact = loop_of(scaled, scene.mu, ("coupling",)).run([(1.0, 0.0), *((step.P, step.Q) for step in schedule)])
    of_states = [_deviations(state, other) for state, other in zip(states, exact[1:], strict=True)]
    work = 0.0
    for before, after in zip(states[QUARTER - 1 :], states[QUARTER:]):
        work -= after["weight"] @ (after["q"] * (after["slip"] - before["slip"]))
    cycle = exact[-1].dissipated_energy - exact[QUARTER].dissipated_energy
    found = of_states[-1] | {"dissipated_energy": abs(work / cycle - 1.0)}
    worst = {name: max(state[name] for state in of_states[QUARTER:]) for name in of_states[-1]}
    largest = max(found.values())
    found |= {"largest": largest, "largest_of_states": max(largest, *worst.values())}
    return found | {f"{name}_of_states": value for name, value in worst.items()}


def _deviations(state, exact):
    x, weight = state["x"], state["weight"]
    left, right = exact.contact
    under = weight * ((x > left) & (x < right))
    return {
        "pressure": relative_l2(weight, state["p"], exact.pressure_at(x)),
        "traction": relative_l2(weight, state["q"], exact.traction_at(x)),
        "slip": relative_l2(under, state["slip"], exact.slip_at(x)),
    }


def _under(mesh, faces, strip):
    """Those of the surface faces that are under the cylinder."""
    return faces[:, [abs(mesh.pts_from_cvid(int(cell))[0][0].mean()) < strip for cell in faces[0]]]


def _without(faces, others):
    left_out = set(map(tuple, others.T))
    return faces[:, [tuple(face) not in left_out for face in faces.T]]
