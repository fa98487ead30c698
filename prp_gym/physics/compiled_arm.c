/* N arms, advanced one after the other with the functions generated from the formulas. */

#define PRP_TURN 3 /* numbers of an angle in `turns`: itself, its sine, its cosine; of the first and third joint */

/* Keep an angle with its sine and its cosine, which are computed where it is another than before. */
static inline void prp_turn(double angle, double *kept)
{
    if (kept[0] == angle && angle != 0.0)
        return;
    kept[0] = angle, kept[1] = sin(angle), kept[2] = cos(angle);
}

static inline int prp_is_beyond(const double *q)
{
    double beyond[3];
    prp_beyond(q, beyond);
    return beyond[0] < 0.0 || beyond[1] < 0.0 || beyond[2] < 0.0;
}

/* Add the constraint of the surface if it is active. */
static inline void prp_collect_surface(
    const double *q, const double *v, const double *plant, const double *surface, const double *turns,
    prp_constraints *c)
{
    double J[3], reference, weight;
    prp_surface_row(q, v, plant, surface, turns, J, &reference, &weight);
    if (weight != 0.0)
        prp_add(c, PRP_SURFACE_ROW, J, reference, weight, -1.0);
}

/* Add the constraints of the joints that are active. */
static inline void prp_collect_joints(
    const prp_world *world, const double *q, const double *v, const double *plant, prp_constraints *c)
{
    double J[9], reference[3], weight[3];
    if (world->friction) {
        prp_friction_rows(q, v, plant, J, reference, weight);
        for (int i = 0; i < 3; i++)
            if (plant[PRP_COULOMB + i] != 0.0)
                prp_add(c, PRP_FRICTION_ROW + i, J + 3 * i, reference[i], weight[i], plant[PRP_COULOMB + i]);
    }
    if (world->stops && prp_is_beyond(q)) {
        prp_stop_rows(q, v, plant, J, reference, weight);
        for (int i = 0; i < 3; i++)
            if (weight[i] != 0.0)
                prp_add(c, PRP_STOP_ROW + i, J + 3 * i, reference[i], weight[i], -1.0);
    }
}

/* The constraints of one arm that are active; the surface is the last. */
static inline void prp_collect(
    const prp_world *world, const double *q, const double *v, const double *plant, const double *surface,
    const double *turns, prp_constraints *c)
{
    c->count = 0;
    prp_collect_joints(world, q, v, plant, c);
    if (world->surface)
        prp_collect_surface(q, v, plant, surface, turns, c);
}

/* The forces of the constraints; `b` becomes b + Σ Jᵀf. `guess` are accelerations from which the solver starts,
   and becomes those that it finds, on which the next ones hardly differ. */
static inline void prp_constrain(prp_constraints *c, const double *B, double *b, double *guess)
{
    if (c->count == 1 && c->row[0] == PRP_SURFACE_ROW) {
        prp_surface_force(B, b, c->jacobian[0], c->reference, c->weight, c->force);
    } else {
        prp_minimise(c, B, b, guess);
    }
    for (int i = 0; i < c->count; i++)
        for (int j = 0; j < 3; j++)
            b[j] += c->jacobian[i][j] * c->force[i];
}

/* The force of the surface, for which the other constraints matter only where it is touched. */
static inline double prp_push(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, const double *turns, double *guess)
{
    double B[9], b[3];
    prp_constraints c, touched;
    touched.count = c.count = 0;
    prp_collect_surface(q, v, plant, surface, turns, &touched);
    if (touched.count == 0)
        return 0.0;
    prp_collect_joints(world, q, v, plant, &c);
    prp_add(&c, PRP_SURFACE_ROW, touched.jacobian[0], touched.reference[0], touched.weight[0], -1.0);
    prp_unconstrained(q, v, tau, plant, turns, B, b);
    prp_constrain(&c, B, b, guess);
    return c.force[c.count - 1];
}

/* One time step; returns whether the arm is lost. */
static inline int prp_step(
    const prp_world *world, double *q, double *v, const double *tau, const double *plant, const double *surface,
    double *turns, double *guess)
{
    double B[9], b[3], later[3], faster[3];
    prp_constraints c;
    int lost = 0;
    prp_turn(q[2], turns + PRP_TURN);
    if (world->surface)
        prp_turn(q[0], turns);
    prp_unconstrained(q, v, tau, plant, turns, B, b);
    prp_collect(world, q, v, plant, surface, turns, &c);
    if (c.count)
        prp_constrain(&c, B, b, guess);
    prp_advanced(q, v, plant, B, b, later, faster);
    for (int j = 0; j < 3; j++) {
        if (isfinite(later[j]) && isfinite(faster[j]))
            q[j] = later[j], v[j] = faster[j];
        else
            lost = 1;
    }
    return lost;
}

static inline int prp_substep(
    const prp_world *world, double *q, double *v, const double *tau, const double *plant, const double *surface)
{
    double turns[2 * PRP_TURN] = {0.0};
    double guess[3] = {0.0};
    return prp_step(world, q, v, tau, plant, surface, turns, guess);
}

static inline int prp_inside(const prp_world *world, const double *q, const double *v)
{
    for (int j = 0; j < 3; j++)
        if (!(fabs(q[j]) <= world->bound[j] && fabs(v[j]) <= world->bound[3 + j]))
            return 0;
    return 1;
}

/* Advance and measure some arms, from the first on: those of `rows`, or all in order where it is null. Every
   array has a row for each arm. Returns whether these arms are within limits.

   measured: joint position, joint velocity, pose, pose rate, contact force; beyond: how far joints are beyond
   their stops; lost: whether an arm has left the bounds, where it stays. */
int prp_advance(
    long first, long count, const long *rows, const prp_world *world, double *restrict position,
    double *restrict velocity, const double *restrict torque, const double *restrict plants,
    const double *restrict surfaces, double *restrict measured, double *restrict beyond,
    unsigned char *restrict lost)
{
    const int width = world->surface ? 21 : 18;
    double own[2 * PRP_TURN] = {0.0};
    int inside = 1;
    for (long index = first; index < first + count; index++) {
        const long row = rows ? rows[index] : index;
        double *q = position + 3 * row, *v = velocity + 3 * row;
        const double *tau = torque + 3 * row, *plant = plants + PRP_PLANT * row;
        const double *surface = surfaces + PRP_SURFACE * row;
        double *turns = world->turns ? world->turns + 2 * PRP_TURN * row : own;
        double guess[3] = {0.0};
        for (int k = 0; k < world->substeps && !lost[row]; k++)
            lost[row] = prp_step(world, q, v, tau, plant, surface, turns, guess);
        lost[row] |= !prp_inside(world, q, v);
        double *out = measured + width * row;
        prp_turn(q[0], turns), prp_turn(q[2], turns + PRP_TURN);
        prp_measured(q, v, turns, out);
        if (world->surface) {
            const double push = prp_push(world, q, v, tau, plant, surface, turns, guess);
            for (int j = 0; j < 3; j++)
                out[18 + j] = -push * surface[8 + j];
        }
        if (world->stops) {
            prp_beyond(q, beyond + 3 * row);
            inside &= beyond[3 * row] == 0.0 && beyond[3 * row + 1] == 0.0 && beyond[3 * row + 2] == 0.0;
        }
        inside &= !lost[row];
    }
    return inside;
}

/* Set the plants of `rows`; dynamics has the columns mass factors, viscous friction, Coulomb friction. */
void prp_set_plants(long count, const long *rows, const double *restrict dynamics, double *restrict plants)
{
    for (long index = 0; index < count; index++) {
        const double *given = dynamics + 9 * rows[index];
        prp_plant_row(given, given + 3, given + 6, plants + PRP_PLANT * rows[index]);
    }
}
