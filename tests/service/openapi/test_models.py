from service.openapi.models import GamutDescription, JobDescription, Level


def test_a_built_gamut_is_as_documented(server, gamut):
    answer = server.client.get(gamut["links"]["self"]).json()
    GamutDescription.model_validate(answer, strict=True)
    # bare colours have no device surface
    assert set(GamutDescription.model_fields) - {"device_surface_volume"} <= set(answer)
    for level in answer["levels"]:
        assert set(Level.model_fields) <= set(level)


def test_a_job_is_as_documented(server, gamut):
    answer = server.client.get(f"/v1/jobs/{gamut['id']}").json()
    JobDescription.model_validate(answer, strict=True)
    assert set(answer) == set(JobDescription.model_fields)
