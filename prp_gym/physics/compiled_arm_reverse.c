/* Exact derivatives of a time step and of the measurement of one arm, by reverse accumulation.

   The acceleration a minimises the cost of constraint_solver.c: B a = b + Σ Jᵢᵀfᵢ. Near a state where no
   constraint is at the edge of its zone, the force of a constraint is fᵢ = -wᵢ (Jᵢ a - rᵢ) in the curved part
   of its cost, ± loss where friction has reached it, and 0 on the free side of a stop or of the surface. Then
   (B + Σ wᵢ Jᵢᵀ Jᵢ) da = db - dB a + Σ (dJᵢᵀ fᵢ + Jᵢᵀ dfᵢ at constant a), the sum on the left over the curved
   ones. The functions `..._transposed` are generated from the formulas, see derivatives_source.py. */

/* Derivatives of a weighted sum of results by what an arm's step depends on. */
typedef struct {
    double position[3], velocity[3], torque[3], plant[PRP_PLANT], surface[PRP_SURFACE];
} prp_adjoints;

static inline void prp_include(double *sum, const double *part, int count)
{
    for (int j = 0; j < count; j++)
        sum[j] += part[j];
}

/* The derivatives through the rows of the constraints, from those by jacobians, references and weights. */
static inline void prp_rows_reverse(
    const prp_constraints *c, const double *q, const double *v, const double *plant, const double *surface,
    const double *d_jacobian, const double *d_reference, const double *d_weight, prp_adjoints *d)
{
    double d_q[3], d_v[3], d_plant[PRP_PLANT], d_surface[PRP_SURFACE];
    const int last = c->row[c->count - 1];
    if (c->row[0] < PRP_STOP_ROW) {
        const int k = PRP_FRICTION_ROW;
        prp_friction_rows_transposed(
            q, v, plant, d_jacobian + 3 * k, d_reference + k, d_weight + k, d_q, d_v, d_plant);
        prp_include(d->position, d_q, 3), prp_include(d->velocity, d_v, 3);
        prp_include(d->plant, d_plant, PRP_PLANT);
    }
    if (last == PRP_SURFACE_ROW) {
        const int k = PRP_SURFACE_ROW;
        prp_surface_row_transposed(
            q, v, plant, surface, d_jacobian + 3 * k, d_reference + k, d_weight + k, d_q, d_v, d_plant, d_surface);
        prp_include(d->position, d_q, 3), prp_include(d->velocity, d_v, 3);
        prp_include(d->plant, d_plant, PRP_PLANT), prp_include(d->surface, d_surface, PRP_SURFACE);
    }
    for (int i = 0; i < c->count; i++)
        if (c->row[i] >= PRP_STOP_ROW && c->row[i] < PRP_SURFACE_ROW) {
            const int k = PRP_STOP_ROW;
            prp_stop_rows_transposed(
                q, v, plant, d_jacobian + 3 * k, d_reference + k, d_weight + k, d_q, d_v, d_plant);
            prp_include(d->position, d_q, 3), prp_include(d->velocity, d_v, 3);
            prp_include(d->plant, d_plant, PRP_PLANT);
            break;
        }
}

/* The forces of the constraints and the accelerations at the minimum; the latter are set where there is one. */
typedef struct {
    prp_constraints c;
    double B[9], total[3], a[3]; /* total: b + Σ Jᵀf */
} prp_minimum;

static inline void prp_find(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, prp_minimum *m)
{
    double turns[2 * PRP_TURN] = {0.0};
    prp_turn(q[0], turns), prp_turn(q[2], turns + PRP_TURN);
    prp_unconstrained(q, v, tau, plant, turns, m->B, m->total);
    prp_collect(world, q, v, plant, surface, turns, &m->c);
    if (m->c.count == 0)
        return;
    memset(m->a, 0, sizeof m->a);
    prp_minimise(&m->c, m->B, m->total, m->a);
    for (int i = 0; i < m->c.count; i++)
        for (int j = 0; j < 3; j++)
            m->total[j] += m->c.jacobian[i][j] * m->c.force[i];
}

/* From the derivatives by b + Σ Jᵀf, `d_total`, and by the force of the surface to those by B and b, of which
   the first is added and the second replaces `d_total`; those through the constraints' rows are added to `d`. */
static inline void prp_minimum_reverse(
    const prp_minimum *m, const double *q, const double *v, const double *plant, const double *surface,
    double d_push, double *d_B, double *d_total, prp_adjoints *d)
{
    const prp_constraints *c = &m->c;
    double hessian[9], right[3] = {0.0}, shift[3], z[PRP_ROWS], stiff[PRP_ROWS], d_f[PRP_ROWS];
    double d_jacobian[3 * PRP_ROWS] = {0.0}, d_reference[PRP_ROWS] = {0.0}, d_weight[PRP_ROWS] = {0.0};
    memcpy(hessian, m->B, sizeof hessian);
    for (int i = 0; i < c->count; i++) {
        const double *J = c->jacobian[i];
        z[i] = prp_dot3(J, m->a) - c->reference[i];
        prp_force(c, i, z[i], &stiff[i]);
        d_f[i] = prp_dot3(J, d_total) + (c->row[i] == PRP_SURFACE_ROW ? d_push : 0.0);
        for (int j = 0; j < 3; j++) {
            right[j] -= stiff[i] * d_f[i] * J[j];
            for (int k = 0; k < 3; k++)
                hessian[3 * j + k] += stiff[i] * J[j] * J[k];
        }
    }
    prp_solve3(hessian, right, shift);
    for (int j = 0; j < 3; j++) {
        d_total[j] += shift[j];
        for (int k = 0; k < 3; k++)
            d_B[3 * j + k] -= shift[j] * m->a[k];
    }
    for (int i = 0; i < c->count; i++) {
        const int row = c->row[i];
        d_f[i] += prp_dot3(c->jacobian[i], shift);
        d_reference[row] = stiff[i] * d_f[i];
        if (stiff[i] != 0.0)
            d_weight[row] = -z[i] * d_f[i];
        else if (c->loss[i] >= 0.0)
            d->plant[PRP_COULOMB + row - PRP_FRICTION_ROW] += c->force[i] > 0.0 ? d_f[i] : -d_f[i];
        for (int j = 0; j < 3; j++)
            d_jacobian[3 * row + j] = c->force[i] * d_total[j] - stiff[i] * d_f[i] * m->a[j];
    }
    prp_rows_reverse(c, q, v, plant, surface, d_jacobian, d_reference, d_weight, d);
}

/* The reverse of `prp_find`; see `prp_minimum_reverse`. */
static inline void prp_find_reverse(
    const prp_minimum *m, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, double d_push, double *d_B, double *d_total, prp_adjoints *d)
{
    double d_q[3], d_v[3], d_torque[3], d_plant[PRP_PLANT];
    if (m->c.count)
        prp_minimum_reverse(m, q, v, plant, surface, d_push, d_B, d_total, d);
    prp_unconstrained_transposed(q, v, tau, plant, d_B, d_total, d_q, d_v, d_torque, d_plant);
    prp_include(d->position, d_q, 3), prp_include(d->velocity, d_v, 3);
    prp_include(d->torque, d_torque, 3), prp_include(d->plant, d_plant, PRP_PLANT);
}

/* The derivatives of d_later·later + d_faster·faster after one time step, by all that it depends on. */
void prp_step_adjoints(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_later, const double *d_faster, prp_adjoints *d)
{
    prp_minimum m;
    double d_B[9], d_total[3];
    memset(d, 0, sizeof *d);
    prp_find(world, q, v, tau, plant, surface, &m);
    prp_advanced_transposed(
        q, v, plant, m.B, m.total, d_later, d_faster, d->position, d->velocity, d->plant, d_B, d_total);
    prp_find_reverse(&m, q, v, tau, plant, surface, 0.0, d_B, d_total, d);
}

/* The derivatives of d_measured·measured, of the columns that `prp_advance` measures, by all that these
   depend on. */
void prp_measured_adjoints(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_measured, prp_adjoints *d)
{
    prp_minimum m;
    double d_B[9] = {0.0}, d_total[3] = {0.0}, d_push = 0.0;
    memset(d, 0, sizeof *d);
    prp_measured_transposed(q, v, d_measured, d->position, d->velocity);
    if (!world->surface)
        return;
    prp_find(world, q, v, tau, plant, surface, &m);
    const int last = m.c.count - 1;
    if (last < 0 || m.c.row[last] != PRP_SURFACE_ROW || m.c.force[last] == 0.0)
        return;
    for (int j = 0; j < 3; j++) {
        d_push -= surface[PRP_NORMAL + j] * d_measured[18 + j];
        d->surface[PRP_NORMAL + j] -= m.c.force[last] * d_measured[18 + j];
    }
    prp_find_reverse(&m, q, v, tau, plant, surface, d_push, d_B, d_total, d);
}

static inline void prp_of_state(const prp_adjoints *d, double *d_q, double *d_v, double *d_tau)
{
    memcpy(d_q, d->position, sizeof d->position);
    memcpy(d_v, d->velocity, sizeof d->velocity);
    memcpy(d_tau, d->torque, sizeof d->torque);
}

/* The same by joint position, joint velocity and torque alone. */
void prp_step_reverse(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_later, const double *d_faster, double *d_q, double *d_v,
    double *d_tau)
{
    prp_adjoints d;
    prp_step_adjoints(world, q, v, tau, plant, surface, d_later, d_faster, &d);
    prp_of_state(&d, d_q, d_v, d_tau);
}

void prp_measured_reverse(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *d_measured, double *d_q, double *d_v, double *d_tau)
{
    prp_adjoints d;
    prp_measured_adjoints(world, q, v, tau, plant, surface, d_measured, &d);
    prp_of_state(&d, d_q, d_v, d_tau);
}
