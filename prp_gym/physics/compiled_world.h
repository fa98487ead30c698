/* What a world has; see `CompiledWorld` of compiled_simulation.py. */
typedef struct {
    int stops, friction, surface, substeps;
    double bound[6], *turns;
} prp_world;
