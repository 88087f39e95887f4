"""Hamilton's equations, frequencies anywhere, steady motions, numbers with units, held values."""

from __future__ import annotations

import re

import pytest

import mecanique as mq

BLOCKS = "v1' = (k2 q2 - (k1 + k2) q1)/m1; v2' = (F + k2 (q1 - q2))/m2"

MATRICES = "[[0,0,1,0],[0,0,0,1],[-(k1+k2)/m1,k2/m1,0,0],[k2/m2,-k2/m2,0,0]]"

APART = "sqrt(g/l + 2 k a^2/(m l^2))"

ANSWERED = (
    # vectors and matrices, whether a vector is written as a row or a column
    ("simple_pendulum", "state space", "[q', w'] = [w, -g/l sin(q)]", "right", ""),
    ("simple_pendulum", "state space", "[q', w'] = [w, g/l sin(q)]", "wrong", "sign"),
    ("simple_pendulum", "state space", "[q', q''] = [q', q'']", "wrong", "holds for any motion"),
    (
        *("simple_pendulum", "state space"),
        r"\begin{pmatrix}\dot q\\ \dot\omega\end{pmatrix} = "
        r"\begin{pmatrix}\omega\\ -\frac{g}{l}\sin q\end{pmatrix}",
        *("right", ""),
    ),
    (
        *("two_blocks", "state space"),
        f"[q1', q2', v1', v2'] = {MATRICES} [q1, q2, v1, v2] + [0,0,0,1/m2] F",
        *("right", ""),
    ),
    (
        *("two_blocks", "state space"),
        rf"\dot{{x}} = A x + B u, A = {MATRICES}, B = [0,0,0,1/m2], u = F, x = [q1,q2,q1',q2']",
        *("right", ""),
    ),
    ("two_blocks", "Hamilton's equations", "[q1', q2'] = [p1/m1, p2/m2]", "incomplete", "2 of 4"),
    # Lagrange's equation with a Lagrangian that the answer gives
    (
        *("simple_pendulum", "equation of motion"),
        "L = T - V, T = m l^2 q'^2/2, V = -m g l cos q; d/dt[dL/dq'] - dL/dq = 0",
        *("right", ""),
    ),
    (
        *("simple_pendulum", "equation of motion"),
        "L = m l^2 q'^2/2 - m g l cos q; d/dt[dL/dq'] - dL/dq = 0",
        *("wrong", "sign"),
    ),
    (
        *("simple_pendulum", "equation of motion", "L = 0; d/dt dL/dq' - dL/dq = 0"),
        *("wrong", "holds for any motion"),
    ),
    (
        *("kepler_orbit", "equation of motion"),
        r"\mathcal{L} = T - V = m/2 (\dot r^2 + r^2 \dot\varphi^2) + m \mu/r \\"
        r"\frac{d}{dt}\frac{\partial \mathcal L}{\partial \dot r} = "
        r"\frac{\partial\mathcal L}{\partial r},"
        r"\frac{d}{dt}\left(\frac{\partial \mathcal L}{\partial \dot\varphi}\right) = 0",
        *("right", ""),
    ),
    (
        *("simple_pendulum", "equation of motion"),
        "L = m l^2 q'^2/2 + m g l cos q; D[D[L, q'[t]], t] - D[L, q[t]] == 0",
        *("right", ""),
    ),
    ("simple_pendulum", "momentum of q", "p = ∂L/∂q̇ = m l² q̇", "right", "set aside"),
    (
        *("simple_pendulum", "Hamilton's equations"),
        "dq/dt = ∂H/∂p = p/(m l^2); dp/dt = -∂H/∂q = -m g l sin q",
        *("right", ""),
    ),
    ("simple_pendulum", "Hamiltonian", "H(q,p) = p^2/(2 m l^2) - m g l cos q", "right", ""),
    ("simple_pendulum", "potential energy", "V(q) = - m g l cos q", "right", ""),
    ("simple_pendulum", "Lagrangian", r"\mathcal L = m l^2\dot q^2/2 + mgl\cos q", "right", ""),
    ("simple_pendulum", "state space", "[q', z'] = [z, -g/l sin q]", "right", "a definition"),
    ("cart_pole", "state space", "[x', q', v', w'] = [v, w, v', w']", "wrong", "any motion"),
    ("rigid_bar_pendulum", "frequency", "√(3·9.81/(2·1)) rad/s", "right except for form", "values"),
    ("rigid_bar_pendulum", "frequency", "√(3·9.81/(2·1)) m/s", "wrong", "units"),
    (
        "spherical_pendulum",
        "momentum of phi",
        r"p_\phi = m l^2 \sin^2\theta\,\dot\phi",
        "right",
        "",
    ),
    ("simple_pendulum", "reaction", "N = R_pin_n", "wrong", "any value"),
    # each of several coordinates by the list of its values
    ("double_pendulum", "equilibrium", "q1 = 0 or π, q2 = 0 or π", "right", ""),
    ("double_pendulum", "equilibrium", "q1 = 0 or π, q2 = 0", "incomplete", "is missing"),
    ("double_pendulum", "equilibrium", "{q1, q2} = {0,0}, {0,π}, {π,0}, {π,π}", "right", ""),
    ("double_pendulum", "equilibrium", "q1 = 0 or π, q2 = 0 or π or 1", "wrong", ""),
    ("cart_pole", "equilibrium", "q = 0 or q = π, x arbitrary", "right", ""),
    ("cart_pole", "equilibrium", "q = n π, x ∈ ℝ", "right", ""),
    ("cart_pole", "equilibrium", "(0, 0), (0, π)", "incomplete", "any other x is missing"),
    ("simple_pendulum", "equilibrium", "q = 0 (stable), q = π (unstable)", "right", ""),
    (
        *("bead_on_hoop", "equilibrium"),
        "theta = 0; theta = pi; theta = ±acos(g/(W^2 R)) if g <= W^2 R",
        *("right", ""),
    ),
    # a subscript of one's own, units beside a letter of the system, and both signs of a rate
    (
        *("elastic_pendulum", "frequency", "ω_r = √(k/m), ω_θ = √(g/(l0 + m g/k))"),
        *("right", "nearest to zero"),
    ),
    ("simple_pendulum", "frequency", "3.13 m/s", "wrong", "units"),
    ("spherical_pendulum", "steady motion", "φ̇ = √(g/(l cos θ))", "right", ""),
    # before the root the same sign gives now the smaller, now the larger rate
    (
        *("heavy_top", "steady motion"),
        "phi' = (-r^2 psi' ± sqrt(r^4 psi'^2 + 5 g h (r^2 - 4 h^2) cos theta))"
        "/((r^2 - 4 h^2) cos theta)",
        *("right", ""),
    ),
    ("simple_pendulum", "reaction", "N = m g cos q + m l q'^2", "right", ""),
    (
        *("double_pendulum", "mass matrix"),
        "{{m1 l1^2/3 + m2 l1^2, m2 l1 l2 Cos[q2 - q1]/2}, {m2 l1 l2 Cos[q2 - q1]/2, m2 l2^2/3}}",
        *("right", ""),
    ),
    (
        *("cart_pole", "mass matrix", "M11 = M + m, M12 = M21 = m l cos q, M22 = m l^2"),
        *("right", ""),
    ),
    ("cart_pole", "mass matrix", "M11 = M + m, M12 = m l sin q, M22 = m l^2", "wrong", "cos"),
    ("simple_pendulum", "Hamiltonian", "H = p^2/(2 m l^2) - m g l cos q", "right", ""),
    ("simple_pendulum", "Hamiltonian", "m l^2 q'^2/2 - m g l cos q", "right except for form", "q'"),
    ("simple_pendulum", "Hamiltonian", "p^2/(m l^2) - m g l cos q", "wrong", "twice"),
    ("simple_pendulum", "Hamilton's equations", "q' = p/(m l^2); p' = -m g l sin q", "right", ""),
    (
        *("simple_pendulum", "Hamilton's equations", "q' = p/(m l^2)", "incomplete"),
        "1 of 2 equations missing",
    ),
    (
        *("simple_pendulum", "Hamilton's equations", "q' = p/(m l^2); q' = p/(m l^2)"),
        *("incomplete", "1 of 2 equations missing"),
    ),
    ("simple_pendulum", "Hamilton's equations", "p' = m l^2 q''", "wrong", "no accelerations"),
    ("simple_pendulum", "Hamilton's equations", "p = m l^2 q' ; p = p", "wrong", "no rate"),
    ("simple_pendulum", "state space", "q' = w; w' = -g/l sin q", "right", ""),
    ("simple_pendulum", "state space", "q' = w; w' = g/l sin q", "wrong", "sign"),
    (
        *("simple_pendulum", "Lagrangian"),
        *("m l^2 q'^2/2 + m g l cos q + m l sqrt(g l) q q'", "right", ""),
    ),
    ("simple_pendulum", "Lagrangian", "m l^2 q'^2/2 + m g l cos q + m l^2 q q'^2", "wrong", ""),
    # only the formula for L alone may differ by a rate, and only by one in its unit
    (
        *("simple_pendulum", "Lagrangian"),
        *("m l^2 q'^2/2 + m g l cos q + 3 m l sqrt(g l) q q' = L", "right", ""),
    ),
    ("simple_pendulum", "Lagrangian", "L = m l^2 q'^2/2 + m g l cos q + q q'", "wrong", "units"),
    ("simple_pendulum", "Lagrangian", "q L = m l^2 q'^2/2 + m g l cos q", "wrong", "factor q"),
    ("simple_pendulum", "Lagrangian", "7 L = m l^2 q'^2/2 + m g l cos q", "wrong", "7"),
    ("simple_pendulum", "Lagrangian", "q L", "wrong", ""),
    ("free_particle", "conserved quantity", "x'", "right", ""),
    ("free_particle", "conserved quantity", "7 x'^0", "wrong", "does not depend on the motion"),
    ("cart_pole", "undamped frequency", "omega = 0; omega = sqrt((1 + m/M) g/l)", "right", ""),
    ("rigid_bar_pendulum", "frequency", "0.61 Hz", "right except for form", "0.610521"),
    ("simple_pendulum", "frequency", "2.0 s", "right except for form", "2.00607"),
    ("simple_pendulum", "frequency", "2.1 s", "wrong", ""),
    ("simple_pendulum", "frequency", "31.3 rad/s", "wrong", ""),
    (
        "simple_pendulum",
        "frequency",
        "ω = √(g/l) ≈ 3.13 rad/s",
        "right",
        "set aside: '≈ 3.13 rad/s'",
    ),
    ("rack_and_pinion", "frequency", "sqrt(k/(M + m/2))", "right", "nearest to zero"),
    (
        *("elastic_pendulum", "frequency", "sqrt(k/m); sqrt(g/(l0 + m g/k))", "right"),
        "nearest to zero",
    ),
    ("elastic_pendulum", "frequency", "sqrt(k/m); sqrt(g/l0)", "wrong", ""),
    ("acrobot", "equilibrium", "q1 = 0, q2 = 0", "incomplete", "q1 = π, q2 = 0 is missing"),
    ("rigid_bar_pendulum", "equilibrium", r"q = n \pi, n \in \mathbb{Z}", "right", "set aside"),
    ("rigid_bar_pendulum", "equilibrium", "q = k pi/2", "wrong", ""),
    # a root of a condition may count twice, or three times
    ("simple_pendulum", "equilibrium", "q sin q = 0", "right", ""),
    ("simple_pendulum", "equilibrium", "cos q = 1; cos q = -1", "right", ""),
    ("simple_pendulum", "equilibrium", "sin q (1 + cos q) = 0", "right", ""),
    ("simple_pendulum", "equilibrium", "1 - cos q = 0", "incomplete", "q = π is missing"),
    (
        *("double_pendulum", "equilibrium", "(q1, q2) = (0, 0), (0, π), (π, 0), (π, π)"),
        *("right", ""),
    ),
    ("double_pendulum", "equilibrium", "(0, 0) and (π, π)", "incomplete", "q1 = π, q2 = 0 is"),
    ("double_pendulum", "equilibrium", "q1, q2 = 0, 0 or 0, π or π, 0 or π, π", "right", ""),
    (
        *("double_pendulum", "equilibrium", "q1 = q2 = 0; q1, q2 = 0, π; q1 = π, q2 = 0; q1=q2=π"),
        *("right", ""),
    ),
    ("two_blocks", "state space", BLOCKS, "right", ""),
    (
        *("two_blocks", "state space", f"v1 = q1'; v2 = q2'; {BLOCKS}; q1' = v1; q2' = v2"),
        *("right", "taken as a definition: 'q1' = v1'"),
    ),
    ("simple_pendulum", "state space", "x1 = q; x2 = q'; x1' = x2", "wrong", "for any motion"),
    (
        *("crane", "equation of motion"),
        "(M + m) x'' + m l (cos(theta) theta'' - sin(theta) theta'^2) - 2 m w cos(theta) theta' = F"
        "; x'' cos theta + l theta'' - 2 w theta' + g sin theta = 0; l = l0 - t w",
        *("right", "taken as a definition: 'l = l0 - t w'"),
    ),
    (
        *("rolling_disk", "equation of motion", "x'' = 1.933", "right except for form"),
        "it is 1.9327",
    ),
    ("rigid_bar_pendulum", "equilibrium", "q = 2 k pi", "incomplete", "q = π is missing"),
    ("rigid_bar_pendulum", "state space", "x1' = x2; x2' = -3 g/(2 l) sin x1", "right", ""),
    ("rigid_bar_pendulum", "state space", "x1' = x2; x2' = 3 g/(2 l) sin x1", "wrong", "sign"),
    ("simple_pendulum", "equation of motion", "see page 3", "wrong", "no letter of the system"),
    (
        *("simple_pendulum", "equation of motion", "On trouve: (1/2) l q'' = -(1/2) g sin q"),
        *("right", "set aside: 'On trouve'"),
    ),
    (
        *("rigid_bar_pendulum", "equation of motion", "q'' = -(3g/2l) sin q"),
        *("right except for form", "/2l is read as /(2l)"),
    ),
    ("rigid_bar_pendulum", "equation of motion", "q'' = (3g/2l) sin q", "wrong", ""),
    (
        *("simple_pendulum", "equation of motion"),
        r"\frac{d}{dt}\frac{\partial L}{\partial \dot q} - \frac{\partial L}{\partial q} = 0"
        r" \Rightarrow \ddot q + \frac gl \sin q = 0",
        *("right", "set aside"),
    ),
    ("base_excited_mass", "damped frequency", "sqrt(k/m)", "wrong", "it is the undamped frequency"),
    ("cart_pole", "kinetic energy", "M x'^2/2 + m l^2 q'^2/2", "wrong", "is missing"),
    (
        *("furuta_pendulum", "kinetic energy"),
        "(M/3 + m) r^2 alpha'^2/2 + m l^2 theta'^2/2 + m r l cos(theta) alpha' theta'",
        *("wrong", "is missing"),
    ),
    (
        *("acrobot", "kinetic energy"),
        "m1 l1^2 q1'^2/6 + m2 (l1^2 q1'^2 + l1 l2 q1' q2' cos q2 + l2^2 q2'^2/3)/2",
        *("wrong", "the rate of q2 is taken absolute instead of relative to q1"),
    ),
    (
        *("two_link_arm", "mass matrix"),
        "[[(m1/3 + m2) l1^2, m2 l1 l2 cos(q2)/2], [m2 l1 l2 cos(q2)/2, m2 l2^2/3]]",
        *("wrong", "the rate of q2 is taken absolute instead of relative to q1"),
    ),
    (
        *("two_link_arm", "potential energy"),
        "-m1 g l1/2 cos q1 - m2 g (l1 cos q1 + l2/2 cos(q1 + q2))",
        *("wrong", "q1 is counted from a line at right angles"),
    ),
    (
        *("cart_pole", "conserved quantity", "(M + m) x' + m l q' cos q", "wrong"),
        "only without the forces",
    ),
    ("simple_pendulum", "frequency at q = 0", "sqrt(g/l)", "right", ""),
    (
        *("bead_on_hoop", "frequency at theta = acos(g/(W^2 R))"),
        *("sqrt(W^2 - g^2/(W^2 R^2))", "right", ""),
    ),
    (
        *("bead_on_hoop", "frequency at theta = acos(g/(W^2 R))"),
        *("sqrt(W^2 - g/R)", "wrong", ""),
    ),
    ("base_excited_mass", "undamped frequency", "sqrt(k/m)", "right", ""),
    ("base_excited_mass", "damped frequency", "sqrt(k/m - c^2/(4 m^2))", "right", ""),
    ("base_excited_mass", "damped frequency", "sqrt(k/m)", "wrong", ""),
    (
        *("two_link_arm", "equilibrium force", "tau2 = m2 g l2/2 cos(q1 + q2)"),
        *("incomplete", "1 of 2 equations missing"),
    ),
    (
        *("two_link_arm", "equilibrium force"),
        "tau2 = m2 g l2/2 cos(q1 + q2); tau1 - tau2 = (m1/2 + m2) g l1 cos q1",
        *("right", ""),
    ),
    ("two_link_arm", "equilibrium force", "tau2 = m2 g l2 cos(q1 + q2)", "wrong", ""),
    ("spherical_pendulum", "steady motion", "phi'^2 = g/(l cos theta)", "right", ""),
    ("spherical_pendulum", "steady motion", "cos theta = g/(l phi'^2)", "right", ""),
    ("spherical_pendulum", "steady motion", "phi'^2 = g/l", "wrong", ""),
    (
        *("spherical_pendulum", "steady motion"),
        *("(phi'^2 - g/(l cos theta))(phi' - sqrt(g/l)) = 0", "wrong", "other values"),
    ),
    # of what rolls, and with loops
    (
        *("rolling_coin", "steady motion"),
        "5 r sin(lean) cos(lean) yaw'^2 + 6 r cos(lean) yaw' spin' + 4 g sin(lean) = 0",
        *("right", ""),
    ),
    (
        *("rolling_coin", "steady motion"),
        "5 r sin(lean) cos(lean) yaw'^2 + 6 r cos(lean) yaw' spin' - 4 g sin(lean) = 0",
        *("wrong", "the sign of the term '- 4 g sin(lean)' is wrong"),
    ),
    (
        # of the yaw few states have a rate, of the spin all
        *("rolling_coin", "steady motion"),
        "4 r sin(lean) cos(lean) yaw'^2 + 6 r cos(lean) yaw' spin' + 4 g sin(lean) = 0",
        *("wrong", "should be 5/4 times as large"),
    ),
    # the length of the governor's arms, on which its loops depend, is 0.5 m in all states
    ("governor", "conserved quantity", "(J + 2 m l^2 sin(theta1)^2) psi' = const", "right", ""),
    (
        *("governor", "conserved quantity", "(J + 4 m l^3 sin(theta1)^2) psi' = const"),
        *("wrong", "the units do not match"),
    ),
    ("governor", "steady motion", "psi'^2 = 2 ((m + M) g - k (s - a))/(m s)", "right", ""),
    ("governor", "steady motion", "psi'^2 = 2 (m g - k (s - a))/(m s)", "wrong", "m should be"),
    # the slider is outside the crank, as it is assembled
    *(
        (
            *("slider_crank", "kinetic energy"),
            f"m1 r^2 theta'^2/6 + m2 r^2 theta'^2/2 (sin(theta) {sign} r sin(theta) cos(theta)"
            "/sqrt(l^2 - r^2 sin(theta)^2))^2",
            *(outcome, said),
        )
        for sign, outcome, said in (
            ("+", "right", "compared for loops that are assembled starting from zero"),
            ("-", "wrong", ""),
        )
    ),
    *(
        # l = 2.4 r in all states, in some of which the root is real
        (
            *("slider_crank", "kinetic energy"),
            f"{name}m1 r^2 theta'^2/6 + m2/2 (r theta' sin(theta)"
            " (1 + r cos(theta)/sqrt(5.76 r^2 - r^2 sin(theta)^2)))^2",
            *("wrong", ""),
        )
        for name in ("T = ", "")
    ),
    # every side of a chain of equalities counts, as does each of several matrices
    *(
        ("simple_pendulum", ask, f"{first} = {second}", outcome, "")
        for ask, first, right, wrong in (
            ("kinetic energy", "T = m l^2 q'^2/2", "m/2 (l q')^2", "m l^2 q'^2"),
            ("Lagrangian", "L = T - V", "m l^2 q'^2/2 + m g l cos q", "m l^2 q'^2/2"),
            ("frequency", "omega = sqrt(g/l)", "sqrt(g l)/l", "sqrt(g/(2 l))"),
            ("period", "T = 2 pi/omega", "2 pi sqrt(l/g)", "3 pi sqrt(l/g)"),
            ("mass matrix", "M = [[m l^2]]", "[[m l l]]", "[[2 m l^2]]"),
            ("momentum of q", "p = m l^2 q'", "m l l q'", "m l q'"),
            (
                "conserved quantity",
                "E = m l^2 q'^2/2 - m g l cos q",
                "m l (l q'^2/2 - g cos q) = const",
                "m l (l q'^2/2 + g cos q) = const",
            ),
        )
        for second, outcome in ((right, "right"), (wrong, "wrong"))
    ),
    ("simple_pendulum", "mass matrix", "m l^2\n2 m l^2", "wrong", ""),
    (
        *("simple_pendulum", "Hamilton's equations"),
        "q' = p/(m l^2) = 2 p/(m l^2), p' = -m g l sin q",
        *("wrong", ""),
    ),
    *(
        ("spherical_pendulum", "steady motion", f"phi'^2 = g/(l cos(theta)) = {last}", outcome, "")
        for last, outcome in (("g/l/cos(theta)", "right"), ("2 g/(l cos(theta))", "wrong"))
    ),
    ("foucault_pendulum", "frequency", "omega1 = omega2 = sqrt(g/l)", "wrong", "W is taken as"),
    # two modes are not equal, though each is one
    *(
        (
            "coupled_pendulums",
            "frequency",
            f"omega1 = sqrt(g/l) = {second}, omega2 = {APART}",
            *verdict,
        )
        for second, *verdict in (
            ("sqrt(g l)/l", "right", ""),
            (APART, "wrong", "another value than the side before it"),
        )
    ),
    # a number beside its formula holds for these values
    (
        *("simple_pendulum", "frequency", "omega = sqrt(g/l) = 3.132 rad/s"),
        *("right except for form", "for these values"),
    ),
    # of a letter whose value is one, the power that is left out
    ("particle_on_circle", "Hamiltonian", "H = p^2/(2 m)", "wrong", "R^2"),
    ("particle_on_circle", "Hamiltonian", "H = p^2/(2 m R^2)", "right", ""),
    # small oscillations about steady motions; E. T. Whittaker, Analytical Dynamics, 1937, § 92
    *(
        ("spherical_pendulum", "frequency at steady motion", text, outcome, "")
        for text, outcome in (
            ("omega^2 = g (1 + 3 cos(theta)^2)/(l cos theta)", "right"),
            ("omega^2 = phi'^2 (1 + 3 cos(theta)^2)", "right"),
            ("omega = sqrt(g/l)", "wrong"),
            ("omega = 2 phi'", "wrong"),
        )
    ),
    ("kepler_orbit", "frequency at steady motion", "T = 2 pi sqrt(r^3/mu)", "right", ""),
    (
        *("heavy_top", "frequency at steady motion"),
        "omega^2 = phi'^2 - 10 g h cos(theta)/(r^2 + 4 h^2) + (5 g h/((r^2 + 4 h^2) phi'))^2",
        *("right", ""),
    ),
    ("rolling_disk", "reaction", "lambda_contact_x = -m g sin(alpha)/3", "right", ""),
    ("rolling_disk", "reaction", "lambda_contact_x = -m g sin(alpha)", "wrong", ""),
    # with constraints: the pendulum that hangs from a free axle, and linkages
    (
        *("two_wheeled_cart", "frequency"),
        "omega^2 = m g h/(I2 + m h^2 - m^2 h^2/(m + 2 mw + 2 Jw/r^2))",
        *("right", "pitch = 0"),
    ),
    (
        *("two_wheeled_cart", "frequency"),
        *("omega^2 = m g h/(I2 + m h^2 - m^2 h^2/(m + 2 mw))", "wrong", ""),
    ),
    ("bars_and_springs_loop", "frequency", "6 sqrt(k/(17 m))", "right", "alpha = 0"),
    (
        *("slider_crank", "frequency at theta = -pi/2"),
        *("omega^2 = m1 g/2/(m1 r/3 + m2 r)", "right", ""),
    ),
    (
        *("slider_crank", "frequency at theta = -pi/2"),
        *("omega^2 = m1 g/2/(m1 r/3)", "wrong", ""),
    ),
    (
        *("slider_crank", "frequency at theta = 0", "omega^2 = g/r"),
        *(None, "the position in question is not an equilibrium"),
    ),
    ("four_bar_linkage", "frequency at phi = -1.606", "2.9492 rad/s", "right except for form", ""),
    ("slider_crank", "equilibrium", "theta = pi/2, theta = -pi/2", "right", ""),
    ("slider_crank", "equilibrium", "theta = pi/2", "incomplete", "theta = -π/2"),
    ("slider_crank", "equilibrium", "theta = 0", "wrong", ""),
    ("two_wheeled_cart", "equilibrium", "pitch = 0 or pi", "right", ""),
    ("two_wheeled_cart", "equilibrium", "pitch = pi/2", "wrong", ""),
    ("rolling_coin", "equilibrium", "lean = 0", "right", ""),
    ("four_bar_linkage", "equilibrium", "phi = -1.60613", "incomplete", "phi = -1.765"),
    ("rolling_disk", "equilibrium", "none", "right", ""),
    ("free_planar_body", "equilibrium", "There is no equilibrium.", "right", ""),
    ("rigid_bar_pendulum", "equilibrium", "none", "wrong", "there is one: q = "),
    ("n_link_pendulum", "equilibrium", "q1 = q2 = q3 = q4 = 0", "incomplete", "is missing"),
    ("rigid_bar_pendulum", "equilibrium", "q = 0, 3.142", "right except for form", "3.14159"),
    ("rigid_bar_pendulum", "equilibrium", "q = 0, 3.17", "wrong", ""),
    ("rigid_bar_pendulum", "equilibrium", "q = 0 (stable), q = pi (unstable)", "right", ""),
    ("rigid_bar_pendulum", "equilibrium", "q = 0 stable, q = pi stable", "wrong", "not stable"),
    ("rigid_bar_pendulum", "equilibrium", "unstable: q = 0; stable: q = pi", "wrong", "is stable"),
    (
        *("rigid_bar_pendulum", "equilibrium"),
        *("stable equilibrium at q = 0, unstable equilibrium at q = pi", "right", ""),
    ),
    (
        *("rigid_bar_pendulum", "equilibrium"),
        *("q = 0 is unstable and q = pi is stable", "wrong", "it is stable"),
    ),
    ("rigid_bar_pendulum", "equilibrium", "q = 0, pi, both stable", "wrong", "not stable"),
    ("furuta_pendulum", "equilibrium", "theta = 0 or pi; alpha may have any value", "right", ""),
    ("furuta_pendulum", "steady motion", "alpha'^2 = g/(l cos(theta))", "right", "with tau = 0"),
    ("rigid_bar_pendulum", "frequency", "sqrt(3 g/(2 l)) rad/s", "right", ""),
    ("rigid_bar_pendulum", "frequency", r"\sqrt{\frac{3g}{2l}}\,\text{rad/s}", "right", ""),
    ("rigid_bar_pendulum", "frequency", "sqrt(3 g/(2 l)) rad/s^2", "wrong", "units"),
    ("rolling_disk", "equation of motion", "a = 2/3 g sin(alpha)", "right", "a = x''"),
    ("cart_pole", "undamped frequency", "sqrt((M + m) g/(M l))", "right", ""),
    ("cart_pole", "undamped frequency", "0, sqrt((M + m) g/(M l))", "right", ""),
    ("cart_pole", "undamped frequency", "0", "incomplete", "1 of 1 frequencies missing"),
    (
        *("shear_building", "undamped frequency"),
        *("omega_j = 2 sqrt(k/m) sin((2 j - 1) pi/22), j = 1, 2, 3, 4, 5", "right", ""),
    ),
    (
        *("shear_building", "undamped frequency"),
        *("omega_j = 2 sqrt(k/m) sin((2 j - 1) pi/22) for j = 1..4", "incomplete", "1 of 5"),
    ),
    (
        *("bead_on_hoop", "frequency at theta = acos(g/(R W^2))"),
        *("Ω² = W² − g²/(R² W²)", "right", ""),
    ),
    ("simple_pendulum", "frequency", "f = 0.498 Hz (to 3 digits)", "right except for form", ""),
    ("simple_pendulum", "frequency", "179.5 rad/s", "wrong", "in degrees"),
    ("simple_pendulum", "frequency", "T = 2.006 ms", "wrong", "a factor 1000"),
    ("simple_pendulum", "frequency", "3.3 rad/s", "wrong", "the number is 5.4 % too large"),
    ("simple_pendulum", "equation of motion", "diff(q(t),t$2) + g/l*sin(q(t)) = 0", "right", ""),
    (
        "simple_pendulum",
        "equilibrium",
        "q = n π; stable si n est pair, instable sinon",
        "right",
        "",
    ),
    (
        *("bead_on_hoop", "equilibrium"),
        "θ = 0 ist stabil für W² < g/R\nθ = π ist immer instabil\n"
        "θ = ± arccos(g/(R W²)) für W² > g/R",
        *("right", ""),
    ),
    (
        *("elastic_pendulum", "equilibrium"),
        "theta = 0, r = l0 + m*g/k (stable)\n"
        "theta = pi, r = l0 - m*g/k (unstable, only if k*l0 > m*g)",
        *("right", ""),
    ),
    (
        *("rack_and_pinion", "equilibrium"),
        *("Au repos le ressort équilibre le couple : x = D/(k r), position stable.", "right", ""),
    ),
    (
        *("coupled_pendulums", "frequency"),
        "Les pulsations sont ω1 = sqrt(g/l) (en phase) et ω2 = sqrt(g/l + 2 k a^2/(m l^2)).",
        *("right", ""),
    ),
    ("simple_pendulum", "frequency", "f = 0.498 Hz (ω ≈ 3.13 rad/s)", "right except for form", ""),
    (
        *("two_blocks", "undamped frequency"),
        r"\omega_{1,2}^2 = \frac12[\frac{k_1+k_2}{m_1}+\frac{k_2}{m_2} \pm "
        r"\sqrt{(\frac{k_1+k_2}{m_1}+\frac{k_2}{m_2})^2 - \frac{4 k_1 k_2}{m_1 m_2}}]",
        *("right", ""),
    ),
    ("foucault_pendulum", "frequency", "ω = √(g/l) ± W", "right", ""),
    ("foucault_pendulum", "frequency", "omega = sqrt(g/l + W^2)", "wrong", ""),
    (
        *("furuta_pendulum", "frequency"),
        "La frecuencia alrededor de theta = 0 es omega = sqrt((1 + 3*m/M)*g/l).",
        *(None, "it belongs to the question, as in --ask 'frequency at theta = 0'"),
    ),
    # the length of a spring has a letter in the equations
    (
        *("coupled_pendulums", "potential energy"),
        *(r"V = \frac12 k (\rho - d)^2 - m g l (\cos q_1 + \cos q_2)", "right", ""),
    ),
    (
        *("coupled_pendulums", "potential energy"),
        *("V = k (rho - d)/2 - m g l (cos q1 + cos q2)", "wrong", "units"),
    ),
    (
        *("coupled_pendulums", "potential energy"),
        *("V = k (rho - d)^2 - m g l (cos q1 + cos q2)", "wrong", "twice"),
    ),
    ("kepler_orbit", "conserved quantity", "dA/dt = 1/2 r^2 phi' = const", "right", ""),
    ("spherical_pendulum", "conserved quantity", "l_z = m l^2 sin(theta)^2 phi'", "right", ""),
    ("heavy_top", "conserved quantity", "psi' + phi' cos(theta) = n (const)", "right", ""),
    (
        *("double_pendulum", "mass matrix"),
        "[[m1 l1^2/3 + m2 l1^2, m2 l1 l2 cos(q1 - q2)/2], [sym., m2 l2^2/3]]",
        *("right", ""),
    ),
    (
        *("double_pendulum", "mass matrix"),
        "[[m1 l1^2/3 + m2 l1^2, m2 l1 l2 cos(q1 - q2)], [sym., m2 l2^2/3]]",
        *("wrong", ""),
    ),
    ("simple_pendulum", "frequency", "T = 2.006 s", "right except for form", "rounded"),
    ("simple_pendulum", "frequency", "omega = 3.132 rad/s", "right except for form", "3.13209"),
    ("simple_pendulum", "frequency", "omega = 3.232 rad/s", "wrong", ""),
    ("simple_pendulum", "frequency", "f = 3.132 Hz", "wrong", ""),
    ("simple_pendulum", "frequency", "T = 2.006 rad/s", "wrong", "units"),
    (
        *("rigid_bar_pendulum", "equation of motion"),
        *("0.333 m l^2 q'' + 0.5 m g l sin q = 0", "right except for form", "it is 1/3"),
    ),
    (
        *("rigid_bar_pendulum", "equation of motion"),
        *("0.34 m l^2 q'' + 0.5 m g l sin q = 0", "wrong", ""),
    ),
    (
        *("rigid_bar_pendulum", "kinetic energy"),
        *("0.167 m l^2 q'^2", "right except for form", "it is 1/6"),
    ),
)


@pytest.mark.parametrize(("system", "ask", "text", "outcome", "said"), ANSWERED)
def test_a_further_question_is_answered(
    system: str, ask: str, text: str, outcome: str | None, said: str
) -> None:
    if outcome is None:
        with pytest.raises(mq.InputError, match=re.escape(said)):
            mq.check(mq.textbook.load(system), text, ask)
        return
    verdict = mq.check(mq.textbook.load(system), text, ask)
    assert verdict.outcome == outcome, str(verdict)
    assert said in str(verdict)


POLES = "(s ((M s + c)(l s^2 + g) + m g s))"


@pytest.mark.parametrize(
    "text",
    [
        f"G(s) = (l s^2 + g)/{POLES}",
        f"X/F = (l s^2 + g)/{POLES}",
        rf"\frac{{X(s)}}{{F(s)}} = \frac{{l s^2 + g}}{{{POLES}}}",
        f"{POLES} X(s) = (l s^2 + g) F(s)",
    ],
)
def test_a_transfer_function_is_read_as_it_is_written(text: str) -> None:
    cart = mq.textbook.load("cart_pole")
    assert mq.check(cart, text, "transfer function of x from F").right


def test_a_transfer_function_is_judged() -> None:
    blocks = mq.textbook.load("two_blocks")
    whole = "(m1 s^2 + k1 + k2)/((m1 s^2 + k1 + k2)(m2 s^2 + k2) - k2^2)"
    assert mq.check(blocks, whole, "transfer function of q2 from F").right
    part = "1/(m2 s^2 + k2)"
    assert mq.check(blocks, part, "transfer function of q2 from F").outcome == "wrong"
    with pytest.raises(mq.InputError, match="transfer function of q1 from F"):
        mq.check(blocks, part, "transfer function of q7")


def test_values_hold_in_every_question() -> None:
    rod = mq.textbook.load("rigid_bar_pendulum", l=2.0)
    verdict = mq.check(rod, "T = m 2^2/6 q'^2", "kinetic energy")
    assert verdict.outcome == "right except for form"
    assert verdict.forms[0] == "right for these values of the parameters only"
    assert mq.check(rod, "T = m 3^2/6 q'^2", "kinetic energy").outcome == "wrong"


@pytest.mark.parametrize(
    ("system", "ask", "message"),
    [
        ("base_excited_mass", "frequency", "ask for the 'undamped frequency'"),
        ("simple_pendulum", "frequency at q = pi", "not stable"),
        ("simple_pendulum", "frequency at q = 1", "not an equilibrium"),
        ("simple_pendulum", "frequency at m = 1", "expected a position"),
        ("simple_pendulum", "steady motion", "no coordinate that may turn uniformly"),
        ("slider_crank", "steady motion", "no coordinate that may turn uniformly"),
        ("rolling_coin", "frequency at steady motion", "mq.linearize_steady computes them"),
        ("simple_pendulum", "frequency at steady motion", "no coordinate that may turn uniformly"),
        ("simple_pendulum", "equilibrium force", "holds it at rest in every position"),
        ("kepler_orbit", "reaction", "no joint or constraint of 'kepler_orbit' transmits a force"),
    ],
)
def test_a_question_without_an_answer_is_refused(system: str, ask: str, message: str) -> None:
    with pytest.raises(mq.InputError, match=message):
        mq.check(mq.textbook.load(system), "q = 0", ask)


ON_HOOP = "theta = 0{}, theta = pi{}, theta = ±acos(g/(R W^2)){}"
SLOW, FAST = "W^2 < g/R", "W^2 > g/R"
REGIMES = (
    f"For {SLOW}: theta = 0 (stable), theta = pi (unstable)\n"
    f"For {FAST}: theta = 0 (unstable), theta = pi (unstable), theta = ±acos(g/(R W^2)) (stable)"
)


@pytest.mark.parametrize(
    ("text", "outcome", "said"),
    [
        (ON_HOOP.format(f" (stable if {SLOW})", " (unstable)", f" if {FAST}"), "right", ""),
        (ON_HOOP.format(f" (stable if {FAST})", "", ""), "wrong", f"is not stable where {FAST}"),
        (
            ON_HOOP.format(" is stable only if W^2 < g/(2 R)", "", ""),
            *("wrong", "it is stable not only where W^2 < g/(2 R)"),
        ),
        (ON_HOOP.format("", f" (unstable for {FAST})", ""), "wrong", "is not stable not only"),
        (ON_HOOP.format("", "", f" ({FAST})"), "right", ""),
        (ON_HOOP.format("", "", " for W² ≥ g/R"), "right", ""),
        (ON_HOOP.format("", "", " falls 0 < g/(R W^2) < 1"), "right", ""),
        (ON_HOOP.format("", "", r" \text{ if } W^2 > \frac{g}{R}"), "right", ""),
        (ON_HOOP.format("", "", f" if {SLOW}"), "wrong", f"there is none where {SLOW}"),
        (
            ON_HOOP.format("", "", " if W^2 > 2 g/R"),
            *("wrong", "it is an equilibrium not only where W^2 > 2 g/R"),
        ),
        (ON_HOOP.format(f" if {SLOW}", "", ""), "wrong", "an equilibrium not only where"),
        (ON_HOOP.format(f" if {SLOW}", "", f"; theta = 0 if {FAST}"), "right", ""),
        (REGIMES, "right", ""),
        (REGIMES.partition("\n")[0], "wrong", "an equilibrium not only where"),
        (REGIMES.replace("theta = 0 (unstable)", "theta = 0 (stable)"), "wrong", "is not stable"),
        # what is no condition on parameters is told
        (ON_HOOP.format("", "", " if theta > 0"), "right", "set aside: 'if theta > 0'"),
        (ON_HOOP.format("", "", " if W > foo"), "right", "set aside: 'if W > foo'"),
    ],
)
def test_conditions_on_parameters_are_judged(text: str, outcome: str, said: str) -> None:
    verdict = mq.check(mq.textbook.load("bead_on_hoop"), text, "equilibrium")
    assert verdict.outcome == outcome
    assert said in str(verdict)


@pytest.mark.parametrize(
    ("limit", "outcome", "said"),
    [
        (FAST, "right", ""),
        (SLOW, "wrong", f"there is none where {SLOW}"),
        ("W^2 > 2 g/R", "wrong", "it holds not only where W^2 > 2 g/R"),
    ],
)
def test_a_frequency_may_hold_under_a_condition(limit: str, outcome: str, said: str) -> None:
    hoop = mq.textbook.load("bead_on_hoop")
    text = f"omega^2 = W^2 - g^2/(R^2 W^2) for {limit}"
    verdict = mq.check(hoop, text, "frequency at theta = acos(g/(R W^2))")
    assert verdict.outcome == outcome
    assert said in str(verdict)


def test_a_condition_that_no_state_meets_is_refused() -> None:
    text = ON_HOOP.format("", "", " if W > 100 sqrt(g/R)")
    with pytest.raises(mq.FormulaError, match="holds in none of the random states"):
        mq.check(mq.textbook.load("bead_on_hoop"), text, "equilibrium")


@pytest.mark.parametrize(
    ("text", "outcome", "said"),
    [
        ("every angle is 0 or π", "right", ""),
        ("every angle q_i is either 0 or π.", "right", ""),
        ("(0, 0) (stable), (0, pi): unstable, (pi, 0) unstable, (pi, pi)", "right", ""),
        ("(0, 0) (unstable), (0, pi), (pi, 0), (pi, pi)", "wrong", "it is stable"),
        ("(0, 0), (0, pi), (pi, 0) if m1 > m2, (pi, pi)", "wrong", "not only where m1 > m2"),
    ],
)
def test_remarks_on_several_coordinates_are_read(text: str, outcome: str, said: str) -> None:
    verdict = mq.check(mq.textbook.load("double_pendulum"), text, "equilibrium")
    assert verdict.outcome == outcome
    assert said in str(verdict)


def test_what_falls_has_no_steady_motion() -> None:
    with pytest.raises(mq.InputError, match="x' keeps 'free_planar_body' steady in none"):
        mq.check(mq.textbook.load("free_planar_body"), "x' = 1", "steady motion")


def test_what_nothing_acts_on_is_steady_at_any_rate() -> None:
    with pytest.raises(mq.InputError, match="with any theta' the motion is steady"):
        mq.check(mq.textbook.load("particle_on_circle"), "theta' = 1", "steady motion")


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_steady_motions_are_judged_at_any_size(scale: float) -> None:
    governor = mq.textbook.load("governor", l=0.5 * scale, a=0.4 * scale)
    text = "psi'^2 = 2 ((m + M) g - k (s - a))/(m s)"
    assert mq.check(governor, text, "steady motion").right
    assert mq.check(governor, text.replace("M", "2 M"), "steady motion").outcome == "wrong"


def test_forces_that_nothing_determines_are_not_asked_for() -> None:
    """The slides keep the disk from moving sideways as well as friction across the slope does."""
    disk = mq.textbook.load("rolling_disk")
    assert mq.check(disk, "lambda_contact_x = -m g sin(alpha)/3", "reaction").right
    with pytest.raises(mq.FormulaError, match="unknown letter"):
        mq.check(disk, "lambda_contact_y = 0", "reaction")
    for system in ("rack_and_pinion", "planetary_gear"):
        with pytest.raises(mq.FormulaError, match="unknown letter"):
            mq.check(mq.textbook.load(system), "nothing_here = 0", "reaction")


CAUSES = (
    ("rigid_bar_pendulum", "kinetic energy", "T = m l^2 q'^2/24", "Steiner's term is missing"),
    ("rigid_bar_pendulum", "kinetic energy", "T = m l^2 q'^2/8", "own center is missing"),
    ("rigid_bar_pendulum", "frequency", "sqrt(g/l)", "point mass at its end"),
    ("rigid_bar_pendulum", "frequency", "T = sqrt(2 l/(3 g))", "a factor 2 pi"),
    ("rigid_bar_pendulum", "equation of motion", "l q'' + g sin q = 0", "point mass at its end"),
    (
        *("rigid_bar_pendulum", "equation of motion"),
        *("m l^2/3 q'' + m g l sin q = 0", "at its end instead of its center"),
    ),
    ("rigid_bar_pendulum", "potential energy", "m g l/2 cos q", "sign of the"),
    ("simple_pendulum", "equation of motion", "q'' + g/l sin(180 q/pi) = 0", "in degrees"),
    (
        *("bead_on_hoop", "conserved quantity"),
        *("m R^2 theta'^2/2 + m W^2 R^2 sin(theta)^2/2 - m g R cos theta", "Jacobi's integral"),
    ),
    ("kepler_orbit", "conserved quantity", "m r phi'", "'r' should be r^2"),
    (
        *("kepler_orbit", "conserved quantity", "m (r'^2 + r^2 phi'^2)/2 + mu m/r"),
        "the sign of the potential energy",
    ),
    ("spherical_pendulum", "conserved quantity", "sin(theta) phi'", "should be squared"),
    ("simple_pendulum", "conserved quantity", "m l^2 q'^2/2 + m g l cos q", "the sign"),
    ("cart_pole", "mass matrix", "[[M + m, 0], [0, m l^2]]", "is missing"),
    (
        *("two_link_arm", "mass matrix"),
        "[[m1 l1^2/3 + m2 l1^2 + m2 l2^2/4 + m2 l1 l2 cos q2, m2 l2^2/4 + m2 l1 l2 cos(q2)/2],"
        "[m2 l2^2/4 + m2 l1 l2 cos(q2)/2, m2 l2^2/4]]",
        "own center is missing",
    ),
    (
        *("spherical_pendulum", "Hamilton's equations"),
        "theta' = ptheta/(m l^2); phi' = pphi/(m l^2 sin(theta)^2); ptheta' = -m g l sin theta; "
        "pphi' = 0",
        "the term m l^2 sin(theta) cos(theta) phi'^2 is missing",
    ),
    (
        *("two_link_arm", "equilibrium force"),
        "tau1 = (m1/2 + m2) g l1 cos(q1); tau2 = m2 g l2 cos(q1 + q2)/2",
        "the term m2 g l2 cos(q1 + q2)/2 is missing",
    ),
    (
        *("cart_pole", "transfer function of x from F"),
        "(l s^2 + g)/(s^2 (M l s^2 + (M + m) g))",
        "the damping is missing",
    ),
    ("spherical_pendulum", "steady motion", "phi' = sqrt(g/l)", "lacks the divisor cos(theta)"),
    ("rigid_bar_pendulum", "equation of motion", "q'' = -3 g/(2 l) tan q", "should be sin"),
    # in a square of a sum no single value is needed
    (
        *("heavy_top", "kinetic energy"),
        "3 m (r^2 + 4 h^2) (theta'^2 + sin(theta)^2 phi'^2)/40 "
        "+ 3 m r^2 (psi' + phi' sin(theta))^2/20",
        "'sin(theta)' should be cos",
    ),
    (
        *("swinging_atwood_machine", "kinetic energy"),
        "T = (M + m) (r'^2 + r^2 theta'^2)/2",
        "in the term 'r^2 theta'^2' (M + m) should be m",
    ),
    (
        *("double_pendulum", "potential energy"),
        "V = -(m1/2 + m2) g l1 sin q1 - m2 g l2 sin(q2)/2",
        "every angle is counted from a line at right angles",
    ),
    (
        *("compound_pendulum", "kinetic energy"),
        "T = (m1 l^2/4 + m2 l^2 + m2 r^2/2) q'^2/2",
        "m1 of 'pendulum' about its own center is missing",
    ),
)


@pytest.mark.parametrize(("system", "ask", "text", "said"), CAUSES)
def test_the_first_cause_names_the_slip(system: str, ask: str, text: str, said: str) -> None:
    verdict = mq.check(mq.textbook.load(system), text, ask)
    assert verdict.outcome == "wrong"
    assert said in verdict.causes[0].text
    assert "should be 1 times" not in str(verdict)


def test_a_constant_momentum_is_no_mistake() -> None:
    text = "r' = pr/m; phi' = pphi/(m r^2); pr' = pphi^2/(m r^3) - m mu/r^2; pphi' = 0"
    assert mq.check(mq.textbook.load("kepler_orbit"), text, "Hamilton's equations").right


def test_a_position_at_which_a_coordinate_means_nothing_is_no_equilibrium() -> None:
    """At r = 0 of the elastic pendulum the balance would give an angle, but there is none."""
    pendulum = mq.textbook.load("elastic_pendulum")
    below, above = "r = l0 + m g/k\ntheta = 0\n", "r = l0 - m g/k\ntheta = pi\n"
    assert mq.check(pendulum, below + above, "equilibrium").right
    half = mq.check(pendulum, below, "equilibrium")
    assert half.outcome == "incomplete"
    assert len(half.forms) == 1
    assert "theta = π" in half.form


FROM_REST = "4 sqrt(l/(2 g))"


@pytest.mark.parametrize(
    "text",
    [
        "T = 4 sqrt(l/g) K(sin(q0/2))",
        "4 Sqrt[l/g] EllipticK[Sin[q0/2]^2]",
        "4*np.sqrt(l/g)*ellipk(np.sin(q0/2)**2)",
        rf"T = {FROM_REST} \int_0^{{q_0}} \frac{{dq}}{{\sqrt{{\cos q - \cos q_0}}}}",
        rf"T = {FROM_REST} \int_0^{{q_0}} (\cos q - \cos q_0)^{{-1/2}} \,\mathrm{{d}}q",
        r"T = 4\sqrt{l/g} \int_0^{\pi/2}\frac{du}{\sqrt{1 - k^2 \sin^2 u}}; k = \sin(q_0/2)",
        f"T = {FROM_REST} ∫_0^q0 dq/sqrt(cos q - cos q0)",
        f"T = {FROM_REST} integral(1/sqrt(cos q - cos q0), q, 0, q0)",
        "4 Sqrt[l/(2 g)] Integrate[1/Sqrt[Cos[q] - Cos[q0]], {q, 0, q0}]",
        f"{FROM_REST} Integral(1/sqrt(cos(q) - cos(q0)), (q, 0, q0))",
    ],
)
def test_a_period_from_rest_is_an_integral(text: str) -> None:
    """Landau & Lifshitz, Mechanics, § 11: the pendulum, by K and by its integral."""
    verdict = mq.check(mq.textbook.load("simple_pendulum"), text, "period from rest")
    assert verdict.right
    assert verdict.notes[-1] == "q0 is the position from which it is released at rest"


@pytest.mark.parametrize(
    ("system", "text", "said"),
    [
        ("simple_pendulum", "2 pi sqrt(l/g)", "it is that of small oscillations"),
        ("simple_pendulum", "2 sqrt(l/g) K(sin(q0/2))", "is half of what it should be"),
        ("simple_pendulum", "4 sqrt(l/g) K(sin(q0/2)^2)", "should be sin(q0/2)"),
        ("rigid_bar_pendulum", "4 sqrt(l/g) K(sin(q0/2))", "should be 2/3 times as large"),
        ("simple_pendulum", "T = T", "it holds for any value"),
    ],
)
def test_slips_in_a_period_from_rest_are_named(system: str, text: str, said: str) -> None:
    verdict = mq.check(mq.textbook.load(system), text, "period from rest")
    assert verdict.outcome == "wrong"
    assert said in verdict.causes[0].text


@pytest.mark.parametrize("system", ["cart_pole", "base_excited_mass", "kapitza_pendulum"])
def test_a_period_without_an_integral_is_refused(system: str) -> None:
    with pytest.raises(mq.InputError, match="from rest is no integral: expected one coordinate"):
        mq.check(mq.textbook.load(system), "T = 1", "period from rest")


def test_a_spring_from_rest_keeps_its_small_period() -> None:
    plate = mq.textbook.load("rotating_plate")
    text = "T = 2 pi sqrt(m (a^2 + b^2)/(3 k))"
    assert mq.check(plate, text, "period from rest").right


def test_an_integral_needs_its_variable() -> None:
    pendulum = mq.textbook.load("simple_pendulum")
    with pytest.raises(mq.FormulaError, match=r"write integral\(f, x, a, b\) for an integral"):
        mq.check(pendulum, "T = ∫ sqrt(l/g)", "period from rest")
    with pytest.raises(mq.FormulaError, match=r"expected integral\(f, x, a, b\), over a letter x"):
        mq.check(pendulum, "T = integral(q, 2, 0, q0)", "period from rest")


@pytest.mark.parametrize(
    "text",
    [
        "w' = -g/l sin(q)\nq' = w",
        "w' = -g/l sin(q); w = q'",
        r"\dot{w} = -g/l \sin q \\ \dot{q} = w",
        "w(t).diff(t) = -g/l*sin(q(t))\nq(t).diff(t) = w(t)",
        "w'[t] == -g/l Sin[q[t]]; q'[t] == w[t]",
    ],
)
def test_equations_of_first_order_stand_in_any_order(text: str) -> None:
    # "w' = …" was taken as the definition of w
    check = mq.check(mq.textbook.load("simple_pendulum"), text)
    assert check.outcome == "right"
    assert not any("sin" in note.lower() for note in check.notes)


def test_a_rate_of_an_undefined_letter_defines_nothing() -> None:
    # the rate lost its primes: the letter was looked up in vain, with KeyError 'qq2'
    with pytest.raises(mq.FormulaError, match="unknown letters \"qq2''\""):
        mq.check(mq.textbook.load("double_pendulum"), "q1 = q2\nqq2'' = q")
