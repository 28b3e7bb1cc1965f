import signal

import uvicorn

from service.server import Server


def test_the_signal_to_stop_is_passed_on_at_once():
    class ServiceContainer:
        draining = False

        def drain(self):
            self.draining = True

    service = ServiceContainer()
    server = Server(uvicorn.Config("nothing:at_all"), service)
    server.handle_exit(signal.SIGTERM, None)
    assert server.should_exit
    assert service.draining
