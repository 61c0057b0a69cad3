"""The contact problem of a load stage: contact terms, and what friction and a held pressure need beside them."""

from dataclasses import dataclass

import ufl
from dolfinx import fem

from forms import contact, weak_form
from forms.contact import X, Y

from .body import ElasticBody
from .contact_terms import ContactTerms
from .point_fields import HeldPressure, NewtonSafeguards, SlipMemory
from .surface_points import SurfacePoints


@dataclass(frozen=True)
class Nitsche:
    """Parameters of the contact terms: gamma = gamma0 degree^2 E/((1-nu^2) h), and the variant theta."""

    gamma0: float = 10.0
    theta: float = 0.0


class ContactProblem:
    """Contact of the body with the indenter, with the effects it is asked for.

    height: numpy function of x, the indenter's profile f(x). ``directions`` lists the contact tractions in the forms,
    each with its rigid displacement: (Y,) without friction; (X, Y) with; (X,) for the tangential problem uncoupled
    from the normal one, whose pressure it holds. mu: coefficient of friction, 0 without; elastic: compliance of elastic
    slip.

    terms: residual, Jacobian and forces; points: of the surface; memory, safeguards: None without friction; held: None
    unless uncoupled.
    """

    def __init__(
        self,
        body: ElasticBody,
        height,
        nitsche: Nitsche,
        directions: tuple[int, ...],
        mu: float = 0.0,
        elastic: float = 0.0,
    ):
        self.body, self.directions, self.mu, self.elastic = body, directions, mu, elastic
        self.points = SurfacePoints(body)
        self.held = None if Y in directions else HeldPressure(self.points)
        law = self._law(height, nitsche)
        self.terms = ContactTerms(self.points, law, self.held)
        self.memory = self.safeguards = None
        if self.friction:
            self.memory = SlipMemory(self.points, law)
            self.safeguards = NewtonSafeguards(self.points, law)

    @property
    def friction(self) -> bool:
        """True where there are tangential tractions."""
        return X in self.directions

    def hold_pressure(self, normal: "ContactProblem"):
        """Hold the pressure that the frictionless problem has now; its state is the body's."""
        assert self.held and normal.terms.pressure  # which stages these are is fixed by their directions
        self.held.hold(normal.terms.pressure, normal.terms.nodal_forces(Y))  # theta is 0 here: there are no others

    def _law(self, height, nitsche) -> weak_form.Contact:
        body, points = self.body, self.points
        gamma = body.constant(nitsche.gamma0 * body.degree**2) * body.solid.surface_modulus / body.cell_height
        parameters = weak_form.NitscheParameters(gamma, body.constant(nitsche.theta) if nitsche.theta else None)
        u, pi = body.u, body.pi
        if self.held is not None:
            held_u, held_pi = body.split(self.held.state)
            u, pi = u - held_u, None if pi is None else pi - held_pi
        t = weak_form.surface_traction(body.solid, u, pi)
        if not self.friction:
            return weak_form.frictionless_contact(u, t, body.delta, self._profile(height), parameters)
        friction = weak_form.Friction(
            mu=body.constant(self.mu),
            anchor=points.field("anchor"),
            imposed=points.field("imposed"),
            stretch=None if body.strain is None else contact.stretch(body.strain, ufl.SpatialCoordinate(body.mesh)[0]),
            elastic=body.constant(self.elastic) if self.elastic else None,
        )
        if self.held is not None:
            return weak_form.tangential_contact(u, t, body.delta, self.held.pressure, parameters, friction)
        return weak_form.frictional_contact(u, t, body.delta, self._profile(height), parameters, friction)

    def _profile(self, height) -> fem.Function:
        """Nodal values of f(x), of the displacements' degree: the contact terms live at their nodes."""
        profile = fem.Function(fem.functionspace(self.body.mesh, ("Lagrange", self.body.degree)))
        profile.interpolate(lambda x: height(x[0]), self.body.strip_cells)  # it may end beyond
        return profile
